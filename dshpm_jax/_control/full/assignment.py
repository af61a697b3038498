"""One assignment for the whole recording: which trajectory carries which label."""

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import LinearConstraint, linear_sum_assignment, milp
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from dshpm_jax._control.full.overlap import overlap_blocks
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._types import NO_MATCH

WHOLE = 1e-6  # a share of a pair that is so near to all or nothing is that


def assign(
    problem: LabellingProblem, gain: Float[np.ndarray, "trajectories markers"]
) -> Int[np.ndarray, " trajectories"]:
    """`assign_labels` around the labels that are given."""
    t, fixed = problem.trajectories, problem.fixed
    return fixed.on(assign_labels(gain if fixed.open is None else np.where(fixed.open, gain, 0.0), t.start, t.stop))


def assign_labels(
    gain: Float[np.ndarray, "trajectories markers"],
    start: Int[np.ndarray, " trajectories"],
    stop: Int[np.ndarray, " trajectories"],
) -> Int[np.ndarray, " trajectories"]:
    """The labels of largest total gain; a trajectory has one or none, and a label one trajectory in any frame.

    Solved exactly: where every trajectory can have its best label it has it. The rest is an assignment problem where
    all that want a label share a frame, else a mixed-integer programme. Only positive gains are ever taken. Of equal
    totals the order of trajectories and markers decides.
    """
    which, marker = np.nonzero(gain > 0)
    identity = np.full(len(gain), NO_MATCH, dtype=np.int32)
    if not len(which):
        return identity
    value = gain[which, marker]
    taken = np.zeros(len(which), bool)
    taken[_best_of_each(which, value)] = True
    broken, crowd, component = _broken(which, marker, start, stop, taken)
    if len(broken):
        tangled = _tangled(crowd, component, start[which[broken]], stop[which[broken]])
        for members in _by_key(np.where(tangled, -1, component)):
            pairs = broken[members]
            if tangled[members[0]]:
                taken[pairs] = _solve(value[pairs], _conflicts(which[pairs], marker[pairs], start, stop))
            else:
                taken[pairs] = _matched(which[pairs], crowd[members], value[pairs])
    identity[which[taken]] = marker[taken]
    return identity


def _best_of_each(which: np.ndarray, value: np.ndarray) -> np.ndarray:
    """For each trajectory the pair of largest gain, ties to the lower index."""
    order = np.lexsort((np.arange(len(which)), -value, which))
    return order[np.r_[True, np.diff(which[order]) > 0]]


def _broken(which, marker, start, stop, taken) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of the connected components in which `taken`, the best of each trajectory, has a marker twice in a frame.

    Where it has not, nothing can be better: every trajectory already has the most that it can get. Returns the pairs,
    and the crowd and the component of each.
    """
    best = np.flatnonzero(taken)
    twice = best[_crowded(marker[best], start[which[best]], stop[which[best]])]
    if not len(twice):
        return twice, twice, twice
    crowd = _crowds(marker, start[which], stop[which])
    links = csr_array((np.ones(len(which)), (which, crowd + len(start))), shape=(len(start) + len(which),) * 2)
    component = connected_components(links, directed=False)[1][which]
    broken = np.flatnonzero(np.isin(component, component[twice]))
    return broken, crowd[broken], component[broken]


def _tangled(crowd: np.ndarray, component: np.ndarray, start: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """Pairs of components with a crowd in which not all share a frame."""
    _, place = np.unique(crowd, return_inverse=True)
    last, first = np.zeros(place.max() + 1, int), np.full(place.max() + 1, np.iinfo(int).max)
    np.maximum.at(last, place, start)
    np.minimum.at(first, place, stop)
    return np.isin(component, component[(last >= first)[place]])


def _matched(which: np.ndarray, crowd: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Which pairs to take for the largest total value, where a crowd, like a trajectory, has at most one."""
    (rows, row), (columns, column) = np.unique(which, return_inverse=True), np.unique(crowd, return_inverse=True)
    table = np.zeros((len(rows), len(columns)))
    table[row, column] = value
    chosen = np.zeros(table.shape, bool)
    chosen[linear_sum_assignment(table, maximize=True)] = True
    return chosen[row, column]


def _crowds(marker: np.ndarray, start: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """The number of the crowd of each pair: lives of one marker that hang together through overlaps."""
    order, begins = _in_turn(marker, start, stop)
    crowd = np.empty(len(marker), int)
    crowd[order] = np.cumsum(begins) - 1
    return crowd


def _crowded(marker: np.ndarray, start: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """Pairs whose life begins while an earlier one of the same marker lasts."""
    order, begins = _in_turn(marker, start, stop)
    return order[~begins]


def _in_turn(marker: np.ndarray, start: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs by marker and start, and which of them begin when all earlier lives of their marker are over."""
    order = np.lexsort((start, marker))
    apart = (marker[order] - marker.min()) * (stop.max() + 1)  # markers one after the other on one line of time
    until = np.maximum.accumulate(stop[order] + apart)
    return order, np.r_[True, start[order][1:] + apart[1:] >= until[:-1]]


def _solve(value: np.ndarray, groups: list[np.ndarray]) -> np.ndarray:
    """Which pairs to take for the largest total value, at most one of each group.

    Without asking for whole numbers first: that takes a quarter of the time, and lives along one line of time nearly
    always lead to whole numbers by themselves.
    """
    rows = np.repeat(np.arange(len(groups)), [len(g) for g in groups])
    table = csr_array((np.ones(len(rows)), (rows, np.concatenate(groups))), shape=(len(groups), len(value)))
    at_most_one = LinearConstraint(table, ub=1.0)
    share = milp(-value, bounds=(0, 1), constraints=at_most_one).x
    if np.abs(share - np.round(share)).max() > WHOLE:
        share = milp(-value, integrality=np.ones(len(value)), bounds=(0, 1), constraints=at_most_one).x
    return share > 0.5


def _conflicts(which, marker, start, stop) -> list[np.ndarray]:
    """Sets of pairs of which at most one may be taken, each of two or more."""
    groups = []
    for members in _by_key(which):
        if len(members) > 1:
            groups.append(members)
    for members in _by_key(marker):
        groups += _overlaps(members, start[which[members]], stop[which[members]])
    return groups


def _by_key(key: np.ndarray) -> list[np.ndarray]:
    order = np.argsort(key, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(key[order])) + 1)


def _overlaps(members: np.ndarray, start: np.ndarray, stop: np.ndarray) -> list[np.ndarray]:
    """Maximal sets of intervals that share a frame: those alive when an interval begins, the largest of each run."""
    if len(members) < 2:
        return []
    first = np.unique(start)
    alive = (start <= first[:, None]) & (first[:, None] < stop)
    # A set is part of the next one unless one of its intervals ends before that begins.
    ends = np.where(alive, stop, np.iinfo(stop.dtype).max).min(1)
    maximal = np.append(ends[:-1] <= first[1:], True) & (alive.sum(1) > 1)
    return [members[together] for together in alive[maximal]]


def any_overlap(identity: Int[np.ndarray, " trajectories"], start: np.ndarray, stop: np.ndarray) -> bool:
    """Whether two trajectories with one label share a frame."""
    named = np.flatnonzero(identity != NO_MATCH)
    named = named[np.lexsort((start[named], identity[named]))]
    same = identity[named[1:]] == identity[named[:-1]]
    return bool((same & (start[named[1:]] < stop[named[:-1]])).any())


def margins(
    identity: Int[np.ndarray, " trajectories"],
    evidence: Float[np.ndarray, "trajectories markers"],
    start: Int[np.ndarray, " trajectories"],
    stop: Int[np.ndarray, " trajectories"],
) -> Float[np.ndarray, " trajectories"]:
    """By how many nats each label given beats its best rival; infinite where there is no label."""
    named = identity != NO_MATCH
    margin = np.full(len(identity), np.inf)
    for rows, near, together in overlap_blocks(start, stop):
        own = evidence[rows, identity[rows]]
        others = evidence[rows].copy()
        others[np.arange(len(rows)), identity[rows]] = -np.inf
        rivals = np.where(together, evidence[near][:, identity[rows]].T, -np.inf)
        margin[rows] = np.where(named[rows], own - np.maximum(others.max(1), rivals.max(1)), np.inf)
    return margin
