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

SKIN_MM, SKIN_SHARE = 4.0, 0.03
"""Spread that markers of one bone show: of the order of 4 mm, and of 3 % of their distance."""

REACH_MM = 400.0
"""Distance at which a pair's normalised spread is doubled."""

SAME_PART, NEXT_PART, OTHER_PART = 0.6, 1.5, 4.0
"""Factors on the normalised spread for names of the same part of the body, of parts that meet, of parts that do not."""

UNKNOWN_SPREAD = 1.2
"""A pair that was hardly seen together, or only standing still: neither rigid nor not."""

STILL_SPREAD = 0.2
"""Normalised spread of two markers that never moved apart, so that distance and names have something to weigh."""

CUT_LOW, CUT_HIGH = 0.9, 1.8
"""Groups are never split below the first mean normalised spread nor joined above the second; between, the widest gap
decides."""

MAX_GROUP = 16
"""Markers of a segment at most: more make no better pose, and a match is as long as its largest segment."""


def normalised_spread(statistics: DistanceStatistics, names: Sequence[str]) -> Float[np.ndarray, "markers markers"]:
    """Normalised spread of every pair of markers, no unit; symmetric, zero on the diagonal.

    Our reading: the paper takes segments as given; this is how we find them. The names weigh in by `SAME_PART` and so
    on only where both say a part of the body.
    """
    distance = np.where(np.isfinite(statistics.mean), statistics.mean, 0)
    spread = statistics.spread / np.hypot(SKIN_MM, SKIN_SHARE * distance)
    spread = np.maximum(np.nan_to_num(spread), UNKNOWN_SPREAD * (1 - statistics.evidence))
    spread = (spread + STILL_SPREAD) * (1 + (distance / REACH_MM) ** 2) * name_factor(names)
    np.fill_diagonal(spread, 0)
    return spread


def name_factor(names: Sequence[str]) -> Float[np.ndarray, "markers markers"]:
    """What the names of two markers say about their being on one bone (see `SAME_PART`); 1 where they say nothing."""
    parts = parts_of_each(names)
    factor = np.ones((len(names), len(names)))
    for i, one in enumerate(parts):
        for j, other in enumerate(parts):
            if one and other:
                near = any(meet(a, b) for a in one for b in other)
                factor[i, j] = SAME_PART if one & other else NEXT_PART if near else OTHER_PART
    return factor


def groups(spread: Float[np.ndarray, "markers markers"], names: Sequence[str]) -> list[list[int]]:
    """Average-linkage groups of the markers, each ascending, ordered by their first marker.

    Markers whose names have no part of the body in common are never put together here, however rigid they look: a
    wrist that nobody bent in this recording may bend in the next.
    """
    parts = parts_of_each(names)
    merges = _linkage(spread, parts)
    stop = _cut(np.array([height for *_, height in merges]))
    found = {i: [i] for i in range(len(spread))}
    for a, b, height in merges:
        if height <= stop and a in found and b in found and len(found[a]) + len(found[b]) <= MAX_GROUP:
            found[a] += found.pop(b)
    return sorted(sorted(group) for group in _settle(spread, list(found.values()), parts))


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


def _cut(heights: np.ndarray) -> float:
    """The middle of the widest relative gap between merge heights within the bounds."""
    inside = np.sort(heights[(heights > CUT_LOW) & (heights < CUT_HIGH)])
    edges = np.concatenate([[CUT_LOW], inside, [CUT_HIGH]])
    widest = int(np.argmax(edges[1:] / edges[:-1]))
    return float(np.sqrt(edges[widest] * edges[widest + 1]))


def _settle(spread: np.ndarray, found: list[list[int]], parts: Sequence[frozenset[str]]) -> list[list[int]]:
    """Moves single markers to the group that they are most rigid with; linkage is greedy and may err early."""
    for _ in range(10):
        moved = False
        for marker in range(len(spread)):
            home = next(g for g, group in enumerate(found) if marker in group)
            rest = [[m for m in group if m != marker] for group in found]
            mean = [float(spread[marker, group].mean()) if fits(marker, group, parts) else np.inf for group in rest]
            best = int(np.argmin(mean))
            if best != home and mean[best] < 0.8 * mean[home] and len(found[best]) < MAX_GROUP and rest[home]:
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
