"""Section 4.2 in slow, obvious numpy: tables, culling, ranking, iteration and completion, one hypothesis at a time."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from reference import NO_MATCH, rigid_fit

from dshpm_jax._requests import MatchSegment, Target

MIN_POSE_SPREAD = 12.0  # mm


class Closest:
    """Compares numbers, and remembers how near any comparison came to going the other way.

    A kernel in single precision may decide a comparison the other way that double precision decides by a hair; a test
    then has nothing to compare.
    """

    def __init__(self):
        self.margin = np.inf

    def below(self, value: float, limit: float) -> bool:
        self.margin = min(self.margin, abs(value - limit))
        return value < limit

    def least(self, values: Iterable[float]) -> int:
        ordered = np.sort(np.asarray(list(values), dtype=float))
        finite = ordered[np.isfinite(ordered)]
        if len(finite) > 1:
            self.margin = min(self.margin, finite[1] - finite[0])
        return int(np.argmin(values))


@dataclass
class Match:
    """What becomes of one hypothesis.

    Attributes:
        hypothesis: its place in the request.
        filled, cost: markers with candidates, and their summed cost, by which tables are ranked.
        margin: how near the nearest decision was (mm, or no unit where ratios were compared).
    """

    hypothesis: int
    filled: int
    cost: float
    assigned: np.ndarray
    matched: int
    error: float
    accepted: bool
    fits: int
    margin: float


def mean_residual(relative: np.ndarray) -> float:
    return float(np.mean(relative))


def match_segment(
    asked: MatchSegment,
    max_candidates: int,
    completions: int,
    score: Callable[[np.ndarray], float] = mean_residual,
) -> tuple[dict[int, Match], set[int]]:
    """Every hypothesis that survives culling, and those that do or do not by a hair.

    Arguments:
        max_candidates: candidates kept in a column.
        completions: rounds of completion.
        score: of the residuals over their scales (Eq. 4).
    """
    found, unsure = {}, set()
    for k, (pivot, assumed) in enumerate(zip(asked.pivot, asked.assumed)):
        closest = Closest()
        table, filled, cost = candidate_table(asked, int(pivot), int(assumed), closest)
        if closest.margin < 1e-4:
            unsure.add(k)
        if filled >= asked.target.need:
            assigned = initial_match(asked.target, int(pivot), [column[:max_candidates] for column in table])
            assigned, fits = iterate(asked, assigned, [c[:max_candidates] for c in table], score, closest)
            found[k] = finish(asked, assigned, completions, score, closest, (k, filled, cost, fits))
    return found, unsure


def candidate_table(asked: MatchSegment, pivot: int, assumed: int, closest: Closest):
    """Candidates of each column, best first (Eq. 3); markers that have any; the cost by which tables are ranked."""
    target = asked.target
    table: list[list[int]] = []
    filled, total = 0, 0.0
    apart = np.linalg.norm(asked.points - asked.points[assumed], axis=1)
    for column in range(len(target.markers)):
        cost = np.abs(apart - target.distance[pivot, column]) / target.tolerance[pivot, column]
        costs = {}
        for point in np.flatnonzero(cost < 1.1).tolist():  # the loop is slow enough without those far off
            if is_allowed(asked, pivot, assumed, column, point) and not closest.below(1.0, cost[point]):
                costs[point] = float(cost[point])
        if column == pivot:
            costs = {assumed: 0.0}
        order = sorted(costs, key=lambda point: (costs[point], point))
        for first, second in zip(order, order[1:]):
            closest.below(costs[first], costs[second])
        table.append(order)
        if order:
            filled += int(target.markers[column] != NO_MATCH)
            total += costs[order[0]]
    return table, filled, total


def is_allowed(asked: MatchSegment, pivot: int, assumed: int, column: int, point: int) -> bool:
    """Whether `point` may be a candidate of `column` at all, whatever its distance."""
    if column == pivot or point == assumed:
        return False
    if asked.pinned[column] != NO_MATCH:
        return point == asked.pinned[column]
    return bool(asked.free[point] and asked.rigid[assumed, point])


def initial_match(target: Target, pivot: int, table: list[list[int]]) -> np.ndarray:
    """The first candidate of each column that no earlier column of the pivot sequence has."""
    assigned = np.full(len(table), NO_MATCH)
    for column in np.argsort(target.distance[pivot].astype(np.float32), kind="stable"):
        for point in table[column]:
            if point not in assigned:
                assigned[column] = point
                break
    return assigned


def iterate(asked: MatchSegment, assigned: np.ndarray, table: list[list[int]], score, closest: Closest):
    """Fits, and replaces or drops the worst match, until Eq. 4 holds or three are left; how many fits that took."""
    tried = [0] * len(table)
    fits = 0
    while True:
        there = assigned != NO_MATCH
        relative = residuals(asked, assigned, closest)[0] / asked.target.scale
        fits += 1
        if there.sum() <= 3 or closest.below(score(relative[there]), 1.0):
            return assigned, fits
        worst = closest.least(np.where(there, -relative, np.inf))
        following = NO_MATCH
        candidates, tried[worst] = list(enumerate(table[worst]))[tried[worst] :], len(table[worst])
        for place, point in candidates:
            if point not in assigned:
                following, tried[worst] = point, place + 1
                break
        assigned = assigned.copy()
        assigned[worst] = following


def residuals(asked: MatchSegment, assigned: np.ndarray, closest: Closest):
    """Residuals of the fit (mm, 0 where nothing is matched), all predicted places, and whether there is a pose."""
    there = assigned != NO_MATCH
    points = asked.points[np.maximum(assigned, 0)]
    rotation, translation, _ = rigid_fit(asked.target.shape, points, there)
    predicted = asked.target.shape @ rotation.T + translation
    posed = there.sum() >= 3 and second_spread(asked.target.shape[there], points[there], closest) >= MIN_POSE_SPREAD
    return np.where(there, np.linalg.norm(predicted - points, axis=1), 0.0), predicted, posed


def second_spread(model: np.ndarray, data: np.ndarray, closest: Closest) -> float:
    """The spread (mm) along the second axis; also minds how near two rotations came to fitting equally well."""
    covariance = (data - data.mean(0)).T @ (model - model.mean(0)) / len(model)
    values = np.linalg.svd(covariance, compute_uv=False)
    mirrored = np.sign(np.linalg.det(covariance))
    closest.below(0.0, (values[1] + mirrored * values[2]) / max(values[0], 1e-9))
    second = float(np.sqrt(values[1]))
    closest.below(second, MIN_POSE_SPREAD)
    return second


def finish(asked: MatchSegment, assigned: np.ndarray, completions: int, score, closest: Closest, table) -> Match:
    """Completion by nearest neighbours (Fig. 3), the last fit, and Eqs. 4 and 5."""
    hypothesis, filled, cost, fits = table
    target = asked.target
    is_marker = target.markers != NO_MATCH
    _, predicted, posed = residuals(asked, assigned, closest)
    fits += int(posed and bool((is_marker & (assigned == NO_MATCH)).any()))
    if posed:
        assigned = complete(asked, assigned, predicted, completions, closest)
        there = assigned != NO_MATCH
        error = score((residuals(asked, assigned, closest)[0] / target.scale)[there])
    else:
        error = distance_error(asked, assigned)
    matched = int((is_marker & (assigned != NO_MATCH)).sum())
    accepted = closest.below(error, 1.0) and matched >= target.need
    return Match(hypothesis, filled, cost, assigned, matched, error, accepted, fits, closest.margin)


def complete(asked: MatchSegment, assigned: np.ndarray, predicted, completions: int, closest: Closest) -> np.ndarray:
    """The nearest pair of lost marker and unclaimed point, so many times."""
    assigned = assigned.copy()
    for _ in range(completions):
        pairs = []
        for column in np.flatnonzero(assigned == NO_MATCH):
            if asked.target.markers[column] == NO_MATCH or asked.pinned[column] != NO_MATCH:
                continue
            for point in np.flatnonzero(asked.free):
                apart = float(np.linalg.norm(predicted[column] - asked.points[point]))
                if point not in assigned and closest.below(apart, asked.target.reach[column]):
                    pairs.append((apart, column, point))
        if not pairs:
            break
        _, column, point = pairs[closest.least([apart for apart, _, _ in pairs])]
        assigned[column] = point
    return assigned


def distance_error(asked: MatchSegment, assigned: np.ndarray) -> float:
    """Mean error of the matched distances over their tolerances, for what has no pose."""
    errors = [
        abs(np.linalg.norm(asked.points[assigned[a]] - asked.points[assigned[b]]) - asked.target.distance[a, b])
        / asked.target.tolerance[a, b]
        for a in np.flatnonzero(assigned != NO_MATCH)
        for b in np.flatnonzero(assigned != NO_MATCH)
        if a != b
    ]
    return float(np.mean(errors)) if errors else 0.0
