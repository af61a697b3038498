"""Segment matching as one would write it in numpy (section 4.2): a loop over hypotheses, and stacks of them.

Both build all tables at once and match only what survives culling; they differ in the iterative match.
"""

from typing import NamedTuple

import numpy as np

from dshpm_jax._requests import MatchSegment
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH

MAX_CANDIDATES, COMPLETIONS = 6, 4  # as in the kernel
MIN_SECOND_VALUE = 12.0**2  # mm^2


class Answer(NamedTuple):
    """A row for each hypothesis that survives culling; `hypothesis` is its place in the request."""

    hypothesis: np.ndarray
    assigned: np.ndarray
    error: np.ndarray
    accepted: np.ndarray


def tables(asked: MatchSegment) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Hypotheses that survive, their candidates (hypotheses, columns, MAX_CANDIDATES), and their first matches."""
    target = asked.target
    apart = np.linalg.norm(asked.points[:, None] - asked.points[None], axis=-1)[asked.assumed]
    distance, tolerance = target.distance[asked.pivot], target.tolerance[asked.pivot]
    cost = np.abs(apart[:, None] - distance[:, :, None]) / tolerance[:, :, None]
    point = np.arange(len(asked.points))
    allowed = (asked.free & asked.rigid[asked.assumed])[:, None]
    allowed = np.where((asked.pinned == NO_MATCH)[:, None], allowed, asked.pinned[:, None] == point)
    cost = np.where(allowed & (point != asked.assumed[:, None])[:, None] & (cost <= 1), cost, np.inf)
    row = np.arange(len(cost))
    cost[row, asked.pivot] = np.inf
    cost[row, asked.pivot, asked.assumed] = 0
    filled = (np.isfinite(cost).any(-1) & (target.markers != NO_MATCH)).sum(-1)
    survives = np.flatnonzero(filled >= target.need)
    cost = cost[survives]
    width = min(MAX_CANDIDATES, cost.shape[2])
    table = np.argsort(cost, axis=-1, kind="stable")[:, :, :width]
    table = np.where(np.isfinite(np.take_along_axis(cost, table, -1)), table, NO_MATCH)
    return survives, table, _first(table, np.argsort(distance[survives], axis=1, kind="stable"))


def _first(table: np.ndarray, sequence: np.ndarray) -> np.ndarray:
    row = np.arange(len(table))
    assigned = np.full(table.shape[:2], NO_MATCH)
    for column in sequence.T:
        candidates = table[row, column]
        open_ = (candidates != NO_MATCH) & ~(candidates[:, :, None] == assigned[:, None]).any(-1)
        first = open_.argmax(1)
        assigned[row, column] = np.where(open_.any(1), candidates[row, first], NO_MATCH)
    return assigned


def fit(shape: np.ndarray, points: np.ndarray, there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Predicted places of all columns, and second singular values; over stacks (hypotheses, columns, 3) too."""
    weight = there[..., None] / np.maximum(there.sum(-1), 1)[..., None, None]
    model_mean, data_mean = (weight * shape).sum(-2, keepdims=True), (weight * points).sum(-2, keepdims=True)
    u, s, vt = np.linalg.svd(np.swapaxes(weight * (points - data_mean), -1, -2) @ (shape - model_mean))
    u[..., 2] *= np.sign(np.linalg.det(u @ vt))[..., None]
    return (shape - model_mean) @ np.swapaxes(u @ vt, -1, -2) + data_mean, s[..., 1]


def match_in_loop(asked: MatchSegment) -> Answer:
    """One hypothesis after the other."""
    survives, table, start = tables(asked)
    rows = [_complete_one(asked, _iterate_one(asked, one, begin)) for one, begin in zip(table, start)]
    assigned = np.array([row[0] for row in rows]).reshape(start.shape)
    error, accepted = (np.array([row[k] for row in rows]) for k in (1, 2))
    return Answer(survives, assigned, error, accepted)


def _iterate_one(asked: MatchSegment, table: np.ndarray, assigned: np.ndarray) -> np.ndarray:
    tried = np.zeros(len(assigned), int)
    assigned = assigned.copy()
    while True:
        there = assigned != NO_MATCH
        if there.sum() <= MIN_FIT_POINTS:
            return assigned
        points = asked.points[assigned]
        predicted, _ = fit(asked.target.shape, points, there)
        relative = np.where(there, np.linalg.norm(predicted - points, axis=-1) / asked.target.scale, -1.0)
        if relative[there].mean() < 1.0:
            return assigned
        worst = relative.argmax()
        following = NO_MATCH
        for k in range(tried[worst], table.shape[1]):
            tried[worst] = k + 1
            if table[worst, k] != NO_MATCH and table[worst, k] not in assigned:
                following = table[worst, k]
                break
        assigned[worst] = following


def _complete_one(asked: MatchSegment, assigned: np.ndarray) -> tuple[np.ndarray, float, bool]:
    assigned, error, accepted = _finish(asked, assigned[None])
    return assigned[0], error[0], accepted[0]


def match_in_stacks(asked: MatchSegment) -> Answer:
    """All hypotheses that are not done yet, fitted in one stack."""
    survives, table, assigned = tables(asked)
    active, tried = np.arange(len(assigned)), np.zeros(assigned.shape, int)
    while len(active):
        now = assigned[active]
        there = now != NO_MATCH
        points = asked.points[now]
        predicted, _ = fit(asked.target.shape, points, there)
        relative = np.where(there, np.linalg.norm(predicted - points, axis=-1) / asked.target.scale, -1.0)
        mean = np.where(there, relative, 0).sum(1) / np.maximum(there.sum(1), 1)
        going = (mean >= 1.0) & (there.sum(1) > MIN_FIT_POINTS)
        active, now, worst = active[going], now[going], relative[going].argmax(1)
        candidates = table[active, worst]
        usable = (np.arange(table.shape[2]) >= tried[active, worst][:, None]) & (candidates != NO_MATCH)
        usable &= ~(candidates[:, :, None] == now[:, None]).any(-1)
        place, any_ = usable.argmax(1), usable.any(1)
        assigned[active, worst] = np.where(any_, candidates[np.arange(len(active)), place], NO_MATCH)
        tried[active, worst] = np.where(any_, place + 1, MAX_CANDIDATES)
    return Answer(survives, *_finish(asked, assigned))


def _finish(asked: MatchSegment, assigned: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Completion by the nearest pairs, the last fit, and Eqs. 4 and 5, over a stack of hypotheses.

    A segment of the bench has three markers or more, and a match without a pose is not accepted here.
    """
    target = asked.target
    is_marker = target.markers != NO_MATCH
    there = assigned != NO_MATCH
    predicted, second = fit(target.shape, asked.points[assigned], there)
    posed = (there.sum(1) >= MIN_FIT_POINTS) & (second >= MIN_SECOND_VALUE)
    lacking = ~there & is_marker & (asked.pinned == NO_MATCH) & posed[:, None]
    at = np.flatnonzero(lacking.any(1))
    if len(at):
        apart = np.linalg.norm(predicted[at, :, None] - asked.points, axis=-1)
        near = (apart <= target.reach[:, None]) & lacking[at][:, :, None] & asked.free
        near &= ~(assigned[at][:, :, None] == np.arange(len(asked.points))).any(1)[:, None]
        apart = np.where(near, apart, np.inf)
        for _ in range(COMPLETIONS):
            column, point = np.unravel_index(apart.reshape(len(at), -1).argmin(1), apart.shape[1:])
            k = np.flatnonzero(np.isfinite(apart[np.arange(len(at)), column, point]))
            if not len(k):
                break
            assigned[at[k], column[k]] = point[k]
            apart[k, column[k]] = np.inf
            apart[k, :, point[k]] = np.inf
    there = assigned != NO_MATCH
    points = asked.points[assigned]
    predicted, _ = fit(target.shape, points, there)
    relative = np.where(there, np.linalg.norm(predicted - points, axis=-1) / target.scale, 0)
    error = np.where(posed, relative.sum(1) / np.maximum(there.sum(1), 1), np.inf)
    return assigned, error, (error < 1) & ((there & is_marker).sum(1) >= target.need)
