"""One assignment for the whole recording: which trajectory carries which label."""

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import LinearConstraint, milp
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from dshpm_jax._types import NO_MATCH


def assign_labels(
    gain: Float[np.ndarray, "trajectories markers"],
    start: Int[np.ndarray, " trajectories"],
    stop: Int[np.ndarray, " trajectories"],
) -> Int[np.ndarray, " trajectories"]:
    """The labels of largest total gain; a trajectory has one or none, and a label one trajectory in any frame.

    Solved exactly: where every trajectory can have its best label it has it, the rest is a mixed-integer programme.
    Only positive gains are ever taken. Ties fall to the lower index through the order of the variables.
    """
    which, marker = np.nonzero(gain > 0)
    identity = np.full(len(gain), NO_MATCH, dtype=np.int32)
    if not len(which):
        return identity
    value = gain[which, marker]
    groups = _conflicts(which, marker, start, stop)
    taken = np.zeros(len(which), bool)
    taken[_best_of_each(which, value)] = True
    hard = _broken_components(len(which), groups, taken)
    if hard.any():
        taken[hard] = _solve(value, [g for g in groups if hard[g[0]]], np.flatnonzero(hard))
    identity[which[taken]] = marker[taken]
    return identity


def _best_of_each(which: np.ndarray, value: np.ndarray) -> np.ndarray:
    """For each trajectory the pair of largest gain, ties to the lower index."""
    order = np.lexsort((np.arange(len(which)), -value, which))
    return order[np.r_[True, np.diff(which[order]) > 0]]


def _broken_components(pairs: int, groups: list[np.ndarray], taken: np.ndarray) -> np.ndarray:
    """Pairs of the connected components in which the best of each trajectory break a rule.

    Where they do not, nothing can be better: every trajectory already has the most that it can get.
    """
    if not groups:
        return np.zeros(pairs, bool)
    members = np.concatenate(groups)
    group = np.repeat(np.arange(len(groups)), [len(g) for g in groups])
    links = csr_array((np.ones(len(members)), (group + pairs, members)), shape=(pairs + len(groups),) * 2)
    _, component = connected_components(links, directed=False)
    crowded = np.bincount(group, taken[members], minlength=len(groups)) > 1
    return np.isin(component[:pairs], component[pairs + np.flatnonzero(crowded)])


def _solve(value: np.ndarray, groups: list[np.ndarray], pairs: np.ndarray) -> np.ndarray:
    """Which of `pairs` to take for the largest total value, at most one of each group."""
    rows = np.repeat(np.arange(len(groups)), [len(g) for g in groups])
    columns = np.searchsorted(pairs, np.concatenate(groups))
    table = csr_array((np.ones(len(rows)), (rows, columns)), shape=(len(groups), len(pairs)))
    found = milp(
        -value[pairs],
        integrality=np.ones(len(pairs)),
        bounds=(0, 1),
        constraints=LinearConstraint(table, ub=1.0),
    )
    return found.x > 0.5


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


def margins(
    identity: Int[np.ndarray, " trajectories"],
    evidence: Float[np.ndarray, "trajectories markers"],
    start: Int[np.ndarray, " trajectories"],
    stop: Int[np.ndarray, " trajectories"],
) -> Float[np.ndarray, " trajectories"]:
    """By how many nats each label given beats its best rival; infinite where there is no label."""
    margin = np.full(len(identity), np.inf)
    named = np.flatnonzero(identity != NO_MATCH)
    rows = np.arange(len(named))
    own = evidence[named, identity[named]]
    others = evidence[named].copy()
    others[rows, identity[named]] = -np.inf
    overlap = (start[named, None] < stop[None]) & (start[None] < stop[named, None])
    overlap[rows, named] = False
    rivals = np.where(overlap, evidence[:, identity[named]].T, -np.inf)
    margin[named] = own - np.maximum(others.max(1), rivals.max(1))
    return margin
