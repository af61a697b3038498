"""Iterative segmental matching over all hypotheses at once (section 4.2.2, Eqs. 4 and 5)."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from dshpm_jax._kernels.candidate_table import (
    MAX_CANDIDATES,
    Hypotheses,
    Problems,
    candidate_costs,
    order_candidates,
    rank_tables,
)
from dshpm_jax._kernels.rigid_fit import RigidFit, rigid_fit_lanes, rotate_lanes
from dshpm_jax._scoring import AbstractCandidateScore, AbstractMatchScore
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH

CHUNK = 128  # tables prepared and finished at a time: small enough to stay in the cache
LANES = 128  # hypotheses that iterate side by side


class Matches(NamedTuple):
    """One row a hypothesis, in the order of `rank_tables`; rows from `num_tables` on mean nothing."""

    hypothesis: Int[Array, " hypotheses"]
    assigned: Int[Array, "hypotheses columns"]
    matched: Int[Array, " hypotheses"]
    error: Float[Array, " hypotheses"]
    accepted: Bool[Array, " hypotheses"]
    fits: Int[Array, " hypotheses"]
    num_tables: Int[Array, ""]
    truncated: Int[Array, ""]


@eqx.filter_jit
def match_segments(
    problems: Problems,
    hypotheses: Hypotheses,
    candidate_score: AbstractCandidateScore,
    match_score: AbstractMatchScore,
) -> Matches:
    """Candidate tables, their ranking, the iterative match of each, and completion, for all requests in one call.

    Lanes that finish early take the next table of the queue: the mean hypothesis needs two fits and the worst
    twenty, so a loop in which all lanes wait for the slowest would idle most of the time.
    """
    cost = candidate_costs(problems, hypotheses, candidate_score)
    order, count = rank_tables(problems, hypotheses, cost)
    ranked = Hypotheses(*(field[order] for field in hypotheses))
    table, start, truncated = _prepare(problems, ranked, cost, order, count)
    assigned, fits = _iterate(problems, ranked, table, start, count, match_score)
    assigned, matched, error, accepted, more_fits = _finish(problems, ranked, assigned, count, match_score)
    return Matches(order, assigned, matched, error, accepted, fits + more_fits, count, truncated)


def _by_chunk(count, carry, body):
    """Runs `body(first_row, carry)` over the chunks that hold the first `count` rows."""

    def step(state):
        first, carry = state
        return first + CHUNK, body(first, carry)

    return lax.while_loop(lambda state: state[0] < count, step, (jnp.int32(0), carry))[1]


def _rows(array, first):
    """A chunk of rows; at the end the window slides back, as `_put` does, so that both name the same rows."""
    size = min(CHUNK, array.shape[0])
    return lax.dynamic_slice_in_dim(array, first, size)


def _put(array, rows, first):
    return lax.dynamic_update_slice_in_dim(array, rows, first, 0)


def _prepare(problems: Problems, ranked: Hypotheses, cost, order, count):
    """Ordered candidates of each surviving table, and its initial match."""
    num, columns = ranked.pivot.shape[0], problems.distance.shape[1]

    def body(first, carry):
        table, start, truncated = carry
        candidates, left_out = order_candidates(cost[_rows(order, first)])
        request, pivot = _rows(ranked.request, first), _rows(ranked.pivot, first)
        begin = _first_candidates(candidates, problems.distance[request, pivot])
        return _put(table, candidates, first), _put(start, begin, first), truncated + left_out

    empty = (
        jnp.full((num, columns, MAX_CANDIDATES), NO_MATCH, jnp.int32),
        jnp.full((num, columns), NO_MATCH, jnp.int32),
        jnp.int32(0),
    )
    return _by_chunk(count, empty, body)


def _first_candidates(
    table: Int[Array, "tables columns candidates"], distance: Float[Array, "tables columns"]
) -> Int[Array, "tables columns"]:
    """The top row of each table, column by column along the pivot sequence; no point twice."""
    sequence = jnp.argsort(distance, axis=1)  # non-decreasing distance from the pivot; stable, ties by index
    sequential = jnp.take_along_axis(table, sequence[:, :, None], axis=1).transpose(1, 2, 0)

    def choose(column, chosen):
        choice = jnp.full(table.shape[0], NO_MATCH, jnp.int32)
        for candidate in reversed(range(MAX_CANDIDATES)):
            point = sequential[column, candidate]
            taken = jnp.any(chosen == point[None], axis=0)
            choice = jnp.where((point != NO_MATCH) & ~taken, point, choice)
        return chosen.at[column].set(choice)

    # A loop, although it is short: unrolled over 18 columns it compiles for most of a minute.
    chosen = jnp.full(table.shape[1::-1], NO_MATCH, jnp.int32)
    chosen = lax.fori_loop(0, table.shape[1], choose, chosen)
    back = jnp.argsort(sequence, axis=1)
    return jnp.take_along_axis(chosen.T, back, axis=1)


class _Lanes(NamedTuple):
    """Hypotheses that iterate side by side."""

    row: Int[Array, " lanes"]  # in the queue; `rows` where the lane is idle
    assigned: Int[Array, "columns lanes"]
    tried: Int[Array, "columns lanes"]  # candidates of each column used up
    fits: Int[Array, " lanes"]


def _iterate(problems: Problems, ranked: Hypotheses, table, start, count, score: AbstractMatchScore):
    """Fit, then replace or drop the worst match, until Eq. 4 holds or fewer than three are left."""
    rows, columns = start.shape
    num_lanes = min(LANES, rows)
    num_points = problems.points.shape[1]
    flat_points = problems.points.reshape(-1, 3)

    def fill(lanes: _Lanes, idle, following):
        """Gives the idle lanes the next tables of the queue."""
        row = following + jnp.cumsum(idle, dtype=jnp.int32) - 1
        row = jnp.where(idle, jnp.where(row < count, row, rows), lanes.row)
        fresh = start[jnp.minimum(row, rows - 1)].T
        return _Lanes(
            row,
            jnp.where(idle[None], fresh, lanes.assigned),
            jnp.where(idle[None], 0, lanes.tried),
            jnp.where(idle, 0, lanes.fits),
        ), jnp.minimum(following + jnp.sum(idle, dtype=jnp.int32), count)

    def step(state):
        lanes, following, out_assigned, out_fits = state
        row = jnp.minimum(lanes.row, rows - 1)
        request = ranked.request[row]
        there = lanes.assigned != NO_MATCH
        data = flat_points[request[None] * num_points + jnp.maximum(lanes.assigned, 0)].transpose(0, 2, 1)
        residual = _residuals(problems.shape[request].transpose(1, 2, 0), data, there)
        scale = problems.scale[request].T
        error = _score(score, residual, scale, there)
        num_there = jnp.sum(there, axis=0, dtype=jnp.int32)
        done = (error < 1.0) | (num_there <= MIN_FIT_POINTS) | (lanes.row >= rows)
        moved = _replace_worst(lanes, residual / scale, there, table, row)
        target = jnp.where(done, lanes.row, rows)
        out_assigned = out_assigned.at[target].set(lanes.assigned.T, mode="drop")
        out_fits = out_fits.at[target].set(lanes.fits + 1, mode="drop")
        lanes = _Lanes(
            lanes.row,
            jnp.where(done[None], lanes.assigned, moved.assigned),
            jnp.where(done[None], lanes.tried, moved.tried),
            lanes.fits + 1,
        )
        lanes, following = fill(lanes, done, following)
        return lanes, following, out_assigned, out_fits

    nothing = _Lanes(
        jnp.full(num_lanes, rows, jnp.int32),
        jnp.full((columns, num_lanes), NO_MATCH, jnp.int32),
        jnp.zeros((columns, num_lanes), jnp.int32),
        jnp.zeros(num_lanes, jnp.int32),
    )
    lanes, following = fill(nothing, jnp.ones(num_lanes, bool), jnp.int32(0))
    state = lanes, following, jnp.full_like(start, NO_MATCH), jnp.zeros(rows, jnp.int32)
    state = lax.while_loop(lambda s: jnp.any(s[0].row < rows), step, state)
    return state[2], state[3]


def _replace_worst(lanes: _Lanes, badness, there, table, row) -> _Lanes:
    """The match of the largest relative residual gives way to its next candidate, or to none."""
    columns = badness.shape[0]
    worst = jnp.argmax(jnp.where(there, badness, -1.0), axis=0)
    is_worst = jnp.arange(columns)[:, None] == worst[None]
    tried = jnp.sum(jnp.where(is_worst, lanes.tried, 0), axis=0)
    candidates = table[row, worst]
    now = jnp.sum(jnp.where(is_worst, lanes.assigned, 0), axis=0)
    choice = jnp.full(row.shape, NO_MATCH, jnp.int32)
    used = jnp.full(row.shape, MAX_CANDIDATES, jnp.int32)
    for k in reversed(range(MAX_CANDIDATES)):
        point = candidates[:, k]
        taken = jnp.any(lanes.assigned == point[None], axis=0)
        usable = (k >= tried) & (point != NO_MATCH) & ~taken & (point != now)
        choice = jnp.where(usable, point, choice)
        used = jnp.where(usable, k + 1, used)
    return lanes._replace(
        assigned=jnp.where(is_worst, choice[None], lanes.assigned), tried=jnp.where(is_worst, used[None], lanes.tried)
    )


def _residuals(shape, data, there):
    """Residuals of the rigid fit (mm), 0 where there is no match; lanes last."""
    predicted = _predict(rigid_fit_lanes(shape, data, there.astype(shape.dtype)), shape)
    return jnp.where(there, jnp.sqrt(jnp.sum((predicted - data) ** 2, axis=1)), 0.0)


def _predict(fit: RigidFit, shape):
    """Places of the shape's columns in the data's frame, lanes last."""
    return rotate_lanes(fit.rotation, shape) + fit.translation[None]


def _score(score: AbstractMatchScore, residual, scale, there):
    return jax.vmap(score, in_axes=(1, 1, 1))(residual, jnp.maximum(scale, 1e-6), there)


def _finish(problems: Problems, ranked: Hypotheses, assigned, count, score: AbstractMatchScore):
    """Completion by nearest neighbours (Fig. 3), the last fit, and whether Eqs. 4 and 5 hold."""
    rows = assigned.shape[0]

    def body(first, carry):
        request = _rows(ranked.request, first)
        chunk = _finish_chunk(problems, request, _rows(assigned, first), score)
        return tuple(_put(array, rows, first) for array, rows in zip(carry, chunk))

    empty = (
        jnp.full_like(assigned, NO_MATCH),
        jnp.zeros(rows, jnp.int32),
        jnp.full(rows, jnp.inf, problems.points.dtype),
        jnp.zeros(rows, bool),
        jnp.zeros(rows, jnp.int32),
    )
    return _by_chunk(count, empty, body)


def _finish_chunk(problems: Problems, request, assigned, score: AbstractMatchScore):
    points, free = problems.points[request], problems.free[request]
    shape = problems.shape[request].transpose(1, 2, 0)
    scale, is_marker = problems.scale[request].T, problems.is_marker[request]
    there = (assigned != NO_MATCH).T
    data = _take(points, assigned)
    fit = rigid_fit_lanes(shape, data, there.astype(shape.dtype))
    posed = (fit.rank >= 2) & (jnp.sum(there, axis=0) >= MIN_FIT_POINTS)
    lacking = jnp.any((assigned == NO_MATCH) & is_marker, axis=1) & posed
    predicted = _predict(fit, shape).transpose(2, 0, 1)
    wanted = is_marker & (problems.pinned[request] == NO_MATCH) & posed[:, None]
    completed = _complete(predicted, points, free, assigned, problems.reach[request], wanted)
    there = (completed != NO_MATCH).T
    data = _take(points, completed)
    residual = _residuals(shape, data, there)
    error = jnp.where(
        posed, _score(score, residual, scale, there), _distance_error(problems, request, completed, points)
    )
    matched = jnp.sum((completed != NO_MATCH) & is_marker, axis=1, dtype=jnp.int32)
    accepted = (error < 1.0) & (matched >= problems.need[request])
    return completed, matched, error, accepted, lacking.astype(jnp.int32)


def _take(points, assigned):
    """Points of each column, lanes last."""
    return jnp.take_along_axis(points, jnp.maximum(assigned, 0)[:, :, None], axis=1).transpose(1, 2, 0)


def _complete(predicted, points, free, assigned, reach, wanted):
    """Nearest unclaimed point within reach of each lost marker, nearest pairs first; no point twice.

    As many rounds as there are columns would always do; a hypothesis that lacks more than a few is lost anyway.
    """
    apart = predicted[:, :, None, :] - points[:, None, :, :]
    distance = jnp.sqrt(jnp.sum(apart * apart, axis=-1))
    point = jnp.arange(points.shape[1])[None]
    column = jnp.arange(assigned.shape[1])[None]
    claimed = jnp.any(assigned[:, :, None] == point[None], axis=1)
    open_column = (assigned == NO_MATCH) & wanted
    near = (distance <= reach[:, :, None]) & (free & ~claimed)[:, None, :] & open_column[:, :, None]
    distance = jnp.where(near, distance, jnp.inf)
    for _ in range(min(COMPLETIONS, assigned.shape[1])):
        flat = distance.reshape(distance.shape[0], -1)
        best = jnp.argmin(flat, axis=1)
        found = jnp.take_along_axis(flat, best[:, None], axis=1)[:, 0] < jnp.inf
        at_column, at_point = best // points.shape[1], (best % points.shape[1]).astype(assigned.dtype)
        here = (column == at_column[:, None]) & found[:, None]
        assigned = jnp.where(here, at_point[:, None], assigned)
        gone = here[:, :, None] | ((point == at_point[:, None]) & found[:, None])[:, None, :]
        distance = jnp.where(gone, jnp.inf, distance)
    return assigned


COMPLETIONS = 4  # rounds of completion


def _distance_error(problems: Problems, request, assigned, points):
    """Mean error of the matched pair distances over their tolerance, for matches that have no pose."""
    there = assigned != NO_MATCH
    place = jnp.take_along_axis(points, jnp.maximum(assigned, 0)[:, :, None], axis=1)
    apart = place[:, :, None, :] - place[:, None, :, :]
    error = jnp.abs(jnp.sqrt(jnp.sum(apart * apart, axis=-1)) - problems.distance[request])
    pairs = there[:, :, None] & there[:, None, :] & ~jnp.eye(assigned.shape[1], dtype=bool)[None]
    total = jnp.sum(jnp.where(pairs, error / problems.tolerance[request], 0.0), axis=(1, 2))
    return total / jnp.maximum(jnp.sum(pairs, axis=(1, 2), dtype=total.dtype), 1.0)
