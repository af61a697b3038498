"""Markers into nearly rigid groups that do not overlap yet, and the tree that joins them.

Everything is judged by one number for a pair of markers, its *normalised spread*: how much their distance changes,
against what skin and soft tissue do at that distance. Two markers of one bone are below 1; across a joint that moved it
is well above 2. Two markers far apart may keep their distance by chance (the head and a knee in a dance), and what
stood still shows nothing, so distance counts against a pair, and so do names that say two different parts of the body.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from dshpm_jax._model_building.body_parts import meet, parts_of_each
from dshpm_jax._model_building.statistics import DistanceStatistics
from dshpm_jax._model_building.tuning import TUNING, ModelTuning


def normalised_spread(
    statistics: DistanceStatistics, names: Sequence[str], tuning: ModelTuning = TUNING
) -> Float[np.ndarray, "markers markers"]:
    """Normalised spread of every pair of markers, no unit; symmetric, zero on the diagonal.

    Our reading: the paper takes segments as given; this is how we find them. The names weigh in only where both
    say a part of the body (see `name_factor`).
    """
    distance = np.where(np.isfinite(statistics.mean), statistics.mean, 0)
    spread = statistics.spread / np.hypot(tuning.skin_mm, tuning.skin_share * distance)
    spread = np.maximum(np.nan_to_num(spread), tuning.unknown_spread * (1 - statistics.evidence))
    spread = (spread + tuning.still_spread) * (1 + (distance / tuning.reach_mm) ** 2) * name_factor(names, tuning)
    np.fill_diagonal(spread, 0)
    return spread


def name_factor(names: Sequence[str], tuning: ModelTuning = TUNING) -> Float[np.ndarray, "markers markers"]:
    """What the names of two markers say about their being on one bone, a factor; 1 where they say nothing."""
    parts = parts_of_each(names)
    factor = np.ones((len(names), len(names)))
    for i, one in enumerate(parts):
        for j, other in enumerate(parts):
            if one and other:
                near = any(meet(a, b) for a in one for b in other)
                factor[i, j] = tuning.same_part if one & other else tuning.next_part if near else tuning.other_part
    return factor


def groups(
    spread: Float[np.ndarray, "markers markers"], names: Sequence[str], tuning: ModelTuning = TUNING
) -> list[list[int]]:
    """Average-linkage groups of the markers, each ascending, ordered by their first marker.

    Markers whose names have no part of the body in common are never put together here, however rigid they look: a
    wrist that nobody bent in this recording may bend in the next.
    """
    parts = parts_of_each(names)
    merges = _linkage(spread, parts)
    stop = _cut(np.array([height for *_, height in merges]), tuning)
    found = {i: [i] for i in range(len(spread))}
    for a, b, height in merges:
        if height <= stop and a in found and b in found and len(found[a]) + len(found[b]) <= tuning.max_group:
            found[a] += found.pop(b)
    return sorted(sorted(group) for group in _move_singles(spread, list(found.values()), parts, tuning))


def common_parts(one: frozenset[str], other: frozenset[str]) -> frozenset[str] | None:
    """Parts that both may sit on, where empty means any; `None` if there are none."""
    if not one or not other:
        return one or other
    return one & other or None


def _linkage(spread: np.ndarray, parts: Sequence[frozenset[str]]) -> list[tuple[int, int, float]]:
    """Merges in order, each of two groups named by their lowest marker, with the mean spread between the two."""
    between = spread.astype(float).copy()
    sits = list(parts)
    for i, j in zip(*np.triu_indices(len(spread))):
        if i == j or common_parts(sits[i], sits[j]) is None:
            between[i, j] = between[j, i] = np.inf
    size = np.ones(len(spread))
    merges = []
    while np.isfinite(between).any():
        a, b = sorted(int(k) for k in np.unravel_index(int(np.argmin(between)), between.shape))
        merges.append((a, b, float(between[a, b])))
        joined = (size[a] * between[a] + size[b] * between[b]) / (size[a] + size[b])
        sits[a] = common_parts(sits[a], sits[b]) or frozenset()
        clash = np.array([common_parts(sits[a], other) is None for other in sits])
        between[a] = between[:, a] = np.where(clash, np.inf, joined)
        between[b] = between[:, b] = between[a, a] = np.inf
        size[a] += size[b]
    return merges


def _cut(heights: np.ndarray, tuning: ModelTuning) -> float:
    """The middle of the widest relative gap between merge heights within the bounds."""
    inside = np.sort(heights[(heights > tuning.cut_low) & (heights < tuning.cut_high)])
    edges = np.concatenate([[tuning.cut_low], inside, [tuning.cut_high]])
    widest = int(np.argmax(edges[1:] / edges[:-1]))
    return float(np.sqrt(edges[widest] * edges[widest + 1]))


def _move_singles(
    spread: np.ndarray, found: list[list[int]], parts: Sequence[frozenset[str]], tuning: ModelTuning
) -> list[list[int]]:
    """Moves single markers to the group that they are most rigid with; linkage is greedy and may err early."""
    for _ in range(tuning.move_rounds):
        moved = False
        for marker in range(len(spread)):
            home = next(g for g, group in enumerate(found) if marker in group)
            rest = [[m for m in group if m != marker] for group in found]
            mean = [float(spread[marker, group].mean()) if fits(marker, group, parts) else np.inf for group in rest]
            best = int(np.argmin(mean))
            if (
                best != home
                and mean[best] < tuning.move_factor * mean[home]
                and len(found[best]) < tuning.max_group
                and rest[home]
            ):
                found[home].remove(marker)
                found[best].append(marker)
                moved = True
        if not moved:
            break
    return found


def shared_parts(group: Sequence[int], parts: Sequence[frozenset[str]]) -> frozenset[str]:
    """Parts of the body that all the names in a group allow; empty if they allow none, or say none."""
    named = [parts[marker] for marker in group if parts[marker]]
    return frozenset.intersection(*named) if named else frozenset()


def fits(marker: int, group: Sequence[int], parts: Sequence[frozenset[str]]) -> bool:
    """Whether the group has markers and the names of all of them and `marker` may mean one part of the body."""
    common: frozenset[str] | None = parts[marker]
    for other in group:
        common = None if common is None else common_parts(common, parts[other])
    return bool(group) and common is not None
