"""From groups that do not overlap to segments that do (section 3.1): shared joins, growth of small groups, links.

A marker near a joint is nearly rigid with both neighbours and belongs to both. Sparse sets have parts of the body with
one marker or none of their own (a knee, an elbow): a *link* segment then spans the joint's two markers, such as
{hip, knee}, so that the chain from the root has no hole.
"""

from collections.abc import Sequence, Set
from itertools import combinations

import numpy as np
from jaxtyping import Float

from dshpm_jax._model_building.partition import fits, shared_parts
from dshpm_jax._model_building.tuning import TUNING, ModelTuning
from dshpm_jax._types import MIN_FIT_POINTS


def overlapping(
    found: Sequence[Sequence[int]],
    spread: Float[np.ndarray, "markers markers"],
    parts: Sequence[frozenset[str]],
    tuning: ModelTuning = TUNING,
) -> tuple[list[list[int]], list[list[int]]]:
    """Segments that share markers at the joints, and the tree over them.

    Arguments:
        found: groups of markers that do not overlap and cover all markers.
        spread: normalised spread of every pair of markers.
        parts: parts of the body that each marker's name says, empty where it says nothing.

    Returns the segments (markers ascending) and, for each, its neighbours in the tree.
    """
    segments = [set(group) for group in found]
    for segment in segments:
        _grow(segment, spread, parts, tuning)
    for a, b in edges(spanning_tree(closeness(found, spread, tuning))):
        if not segments[a] & segments[b]:
            _share(segments, a, b, spread, parts, tuning)
        if not segments[a] & segments[b] and _needs_link(found[a], found[b], spread, parts, tuning):
            segments.append(_link(found[a], found[b], spread, tuning))
    kept = _without_subsets(_merged(segments, spread, parts, tuning))
    return kept, spanning_tree(closeness(kept, spread, tuning))


def _grow(segment: set[int], spread: np.ndarray, parts: Sequence[frozenset[str]], tuning: ModelTuning) -> None:
    """Adds the most rigid outside markers, one by one, to a small segment.

    A marker whose name says another part of the body is taken only where a pose would be missing without it.
    """
    while len(segment) < min(tuning.grow_size, len(spread)):
        inside = sorted(segment)
        mean = spread[:, inside].mean(1)
        mean[inside] = np.inf
        suited = np.array([fits(m, inside, parts) for m in range(len(spread))])
        if mean[suited].min(initial=np.inf) <= tuning.grow_spread or len(segment) >= MIN_FIT_POINTS:
            mean[~suited] = np.inf
        best = int(np.argmin(mean))
        if mean[best] > tuning.grow_spread:
            return
        segment.add(best)


def _share(
    segments: list[set[int]], a: int, b: int, spread: np.ndarray, parts: Sequence[frozenset[str]], tuning: ModelTuning
) -> None:
    """Makes the markers of one group that are most rigid with the other members of both."""
    offers = []
    for giver, taker in ((a, b), (b, a)):
        inside = sorted(segments[taker])
        for marker in segments[giver]:
            if fits(marker, inside, parts):
                offers.append((float(spread[marker, inside].mean()), marker, taker))
    for cost, marker, taker in sorted(offers)[: tuning.share_most]:
        if cost < tuning.share_spread and len(segments[taker]) < tuning.max_group:
            segments[taker].add(marker)


def _merged(
    segments: Sequence[set[int]], spread: np.ndarray, parts: Sequence[frozenset[str]], tuning: ModelTuning
) -> list[set[int]]:
    """Segments that share all but one or two markers become one where that is not much looser than its halves."""
    found = [set(segment) for segment in segments]
    again = True
    while again:
        again = False
        for a, b in combinations(range(len(found)), 2):
            both, union = found[a] & found[b], found[a] | found[b]
            if not both or len(union) > tuning.merge_size or min(len(found[a] - both), len(found[b] - both)) != 1:
                continue
            if mean_spread(union, spread) < tuning.merge_spread and _one_part(union, parts):
                found[a] = union
                del found[b]
                again = True
                break
    return found


def mean_spread(segment: Set[int], spread: np.ndarray) -> float:
    """Mean normalised spread over the pairs of a segment."""
    inside = sorted(segment)
    return float(spread[np.ix_(inside, inside)].sum() / max(len(inside) * (len(inside) - 1), 1))


def _one_part(segment: Set[int], parts: Sequence[frozenset[str]]) -> bool:
    inside = sorted(segment)
    return fits(inside[0], inside[1:], parts)


def _needs_link(
    one: Sequence[int], other: Sequence[int], spread: np.ndarray, parts: Sequence[frozenset[str]], tuning: ModelTuning
) -> bool:
    """Whether one side has no pose of its own, or a rigid pair across both is a bone that has no group of its own."""
    if min(len(one), len(other)) < MIN_FIT_POINTS:
        return True
    taken = shared_parts(one, parts) | shared_parts(other, parts)
    return any(spread[i, j] < tuning.rigid_link and (parts[i] & parts[j]) - taken for i in one for j in other)


def _link(one: Sequence[int], other: Sequence[int], spread: np.ndarray, tuning: ModelTuning) -> set[int]:
    """The most rigid pair across two groups, and what is nearly as rigid with it, of the larger if that has a pose."""
    pool = max(one, other, key=len) if max(len(one), len(other)) >= MIN_FIT_POINTS else (*one, *other)
    between = spread[np.ix_(one, other)]
    i, j = np.unravel_index(int(np.argmin(between)), between.shape)
    link = {one[int(i)], other[int(j)]}
    while len(link) < tuning.link_size:
        rest = [m for m in pool if m not in link]
        mean = [float(spread[m, sorted(link)].mean()) for m in rest]
        if min(mean, default=np.inf) > tuning.link_spread:
            break
        link.add(rest[int(np.argmin(mean))])
    return link


def _without_subsets(segments: Sequence[set[int]]) -> list[list[int]]:
    """Segments that no other one contains, in order; of equal ones the first."""
    kept = []
    for s, segment in enumerate(segments):
        if not any(segment < other or (segment == other and o < s) for o, other in enumerate(segments)):
            kept.append(sorted(segment))
    return sorted(kept)


def closeness(
    found: Sequence[Sequence[int]], spread: np.ndarray, tuning: ModelTuning = TUNING
) -> Float[np.ndarray, "groups groups"]:
    """Mean spread over the most rigid pairs between groups; a shared marker is a pair of spread zero."""
    between = np.zeros((len(found), len(found)))
    for a, one in enumerate(found):
        for b, other in enumerate(found):
            between[a, b] = np.sort(spread[np.ix_(one, other)], axis=None)[: tuning.closeness_pairs].mean()
    return between


def spanning_tree(between: Float[np.ndarray, "groups groups"]) -> list[list[int]]:
    """Neighbours of every group in the minimum spanning tree (Prim's, ties by index)."""
    count = len(between)
    links: list[list[int]] = [[] for _ in range(count)]
    inside = [0]
    while len(inside) < count:
        outside = [g for g in range(count) if g not in inside]
        a, b = min(((a, b) for a in inside for b in outside), key=lambda ab: (between[ab], ab))
        links[a].append(b)
        links[b].append(a)
        inside.append(b)
    return links


def edges(links: Sequence[Sequence[int]]) -> list[tuple[int, int]]:
    """Each edge of a tree once."""
    return [(a, b) for a, near in enumerate(links) for b in near if a < b]
