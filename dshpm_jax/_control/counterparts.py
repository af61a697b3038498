"""Left and right, found from distances alone: chains of segments that could be each other.

A trunk turned back to front fits nearly as well as one that is not, and arms that follow it predict themselves. No
exchange of two labels leads out of that, so whole chains are exchanged, alone and with the segment that they hang from.
"""

from collections.abc import Sequence
from itertools import combinations, permutations

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import linear_sum_assignment

from dshpm_jax._control.tuning import Tuning
from dshpm_jax._hierarchy import children, subtree
from dshpm_jax._model import Segment
from dshpm_jax._requests import Target
from dshpm_jax._types import MIN_FIT_POINTS, NO_PARENT


def side_permutations(
    segments: Sequence[Segment],
    targets: Sequence[Target],
    distance: Float[np.ndarray, "markers markers"],
    tuning: Tuning,
) -> list[Int[np.ndarray, " markers"]]:
    """What each label becomes when chains that hang from one segment are exchanged.

    Each pair of counterparts, and all pairs together, with the segment they hang from as it is and permuted.

    Arguments:
        distance: mean distances of all pairs of markers (mm).
    """
    markers = [target.markers for target in targets]
    found = []
    for parent in range(NO_PARENT, len(segments)):
        chains = [_chain(segments, markers, head) for head in children(segments, parent)]
        swaps = _swaps(distance, chains, tuning)
        if len(swaps) > 1:
            swaps.append(_both(swaps))
        found += swaps
        if parent != NO_PARENT:
            found += [whole for swap in swaps for whole in _with_parent(distance, markers[parent], swap, tuning)]
    return found


def _chain(segments: Sequence[Segment], markers: Sequence[np.ndarray], head: int) -> Int[np.ndarray, " chain"]:
    """The markers of a segment and of all that hangs from it."""
    return np.unique(np.concatenate([markers[s] for s in subtree(segments, head)]))


def _swaps(distance: np.ndarray, chains: Sequence[np.ndarray], tuning: Tuning) -> list[np.ndarray]:
    """The exchange of each pair of chains that are counterparts."""
    swaps = []
    for pair in (_counterparts(distance, a, b, tuning) for a, b in combinations(chains, 2)):
        if pair is not None:
            one, other = pair
            to = np.arange(len(distance))
            to[one], to[other] = other, one
            swaps.append(to)
    return swaps


def _counterparts(
    distance: np.ndarray, one: np.ndarray, other: np.ndarray, tuning: Tuning
) -> tuple[np.ndarray, np.ndarray] | None:
    """The markers of two chains side by side, where their distances are alike, else nothing."""
    one, other = np.setdiff1d(one, other), np.setdiff1d(other, one)
    if len(one) != len(other) or len(one) < 2:
        return None
    a, b = distance[np.ix_(one, one)].astype(float), distance[np.ix_(other, other)].astype(float)
    across = distance[np.ix_(one, other)]
    # Markers that correspond have like distances to all others, whichever these are.
    profiles = np.abs(np.sort(a, 1)[:, None] - np.sort(b, 1)[None]).sum(-1)
    order = linear_sum_assignment(profiles)[1]
    order, cost = min((_refined(a, b, across, start) for start in (order, np.arange(len(one)))), key=lambda o: o[1])
    return (one, other[order]) if cost < tuning.max_counterpart_difference * a.mean() else None


def _refined(a: np.ndarray, b: np.ndarray, across: np.ndarray, order: np.ndarray) -> tuple[np.ndarray, float]:
    """The order of the second chain, bettered by exchanges of two, and the mean difference of distances that is left.

    Besides the distances in both chains those across must be alike: from left to right as from right to left.
    """

    def cost(order: np.ndarray) -> float:
        crossed = across[:, order]
        return float(np.abs(a - b[np.ix_(order, order)]).mean() + np.abs(crossed - crossed.T).mean()) / 2

    best = cost(order)
    while True:
        tried = []
        for i, k in combinations(range(len(order)), 2):
            other = order.copy()
            other[[i, k]] = other[[k, i]]
            tried.append((cost(other), i, k))
        least, i, k = min(tried)
        if least >= best:
            return order, best
        order = order.copy()
        order[[i, k]] = order[[k, i]]
        best = least


def _both(swaps: list[np.ndarray]) -> np.ndarray:
    """The swaps together; a marker of several goes with the first."""
    together = np.arange(len(swaps[0]))
    for swap in swaps:
        together = np.where(together == np.arange(len(swap)), swap, together)
    return together


def _with_parent(distance: np.ndarray, own: np.ndarray, swap: np.ndarray, tuning: Tuning) -> list[np.ndarray]:
    """The swap with each permutation of the parent that roughly keeps its shape and moves joins as the swap does."""
    if not MIN_FIT_POINTS <= len(own) <= tuning.max_symmetric_markers:
        return []
    between = distance[np.ix_(own, own)]
    joins = swap[own] != own
    found = []
    for way in map(np.array, permutations(own)):
        if (way[joins] != swap[own][joins]).any() or (way == swap[own]).all():
            continue
        change = np.abs(distance[np.ix_(way, way)] - between).mean()
        if change < tuning.max_counterpart_difference * between.mean():
            to = swap.copy()
            to[own] = way
            found.append(to)
    return found
