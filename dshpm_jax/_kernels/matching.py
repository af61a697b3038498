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
    PivotDistances,
    Problems,
    order_candidates,
    pivot_distances,
    rank_tables,
)
from dshpm_jax._kernels.completion import complete
from dshpm_jax._kernels.rigid_fit import rigid_fit_lanes, rotate_lanes
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
    distances = pivot_distances(problems)
    order, count = rank_tables(problems, distances, hypotheses, candidate_score)
    ranked = Hypotheses(*(field[order] for field in hypotheses))
    table, start = _prepare(problems, distances, ranked, count, candidate_score)
    fitted, fits = _iterate(problems, ranked, table, start, count, match_score)
    assigned, matched, error, accepted, more_fits = _finish(problems, ranked, fitted, count, match_score)
    return Matches(order, assigned, matched, error, accepted, fits + more_fits, count)


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


def _prepare(problems: Problems, distances: PivotDistances, ranked: Hypotheses, count, score: AbstractCandidateScore):
    """Ordered candidates of each surviving table, and its initial match."""
    num, columns = ranked.pivot.shape[0], problems.distance.shape[1]
    sequence = jnp.argsort(problems.distance, axis=2)  # non-decreasing distance from a pivot; stable, ties by index

    def body(first, carry):
        table, start = carry
        here = Hypotheses(*(_rows(field, first) for field in ranked))
        candidates = order_candidates(problems, distances, here, score)
        begin = _first_candidates(candidates, sequence[here.request, here.pivot].T, problems.points.shape[1])
        return _put(table, candidates.transpose(1, 0, 2), first), _put(start, begin.T, first)

    empty = (
        jnp.full((num, columns, MAX_CANDIDATES), NO_MATCH, jnp.int32),
        jnp.full((num, columns), NO_MATCH, jnp.int32),
    )
    return _by_chunk(count, empty, body)


def _first_candidates(
    table: Int[Array, "columns tables candidates"], sequence: Int[Array, "columns tables"], num_points: int
) -> Int[Array, "columns tables"]:
    """The top row of each table, column by column along the pivot sequence; no point twice."""
    lane = jnp.arange(table.shape[1])

    def choose(step, state):
        chosen, taken = state
        candidates = table[sequence[step], lane]
        usable = (candidates != NO_MATCH) & ~taken[lane[:, None], candidates]
        best = jnp.argmax(usable, axis=1)
        choice = jnp.where(usable.any(1), candidates[lane, best], NO_MATCH)
        taken = taken.at[lane, jnp.where(choice == NO_MATCH, num_points, choice)].set(True, mode="drop")
        return chosen.at[sequence[step], lane].set(choice), taken

    # A loop, although it is short: unrolled over 18 columns it compiles for most of a minute.
    nothing = jnp.full(sequence.shape, NO_MATCH, jnp.int32), jnp.zeros((len(lane), num_points), bool)
    return lax.fori_loop(0, len(sequence), choose, nothing)[0]


class _Lanes(NamedTuple):
    """Hypotheses that iterate side by side."""

    row: Int[Array, " lanes"]  # in the queue; `rows` where the lane is idle
    assigned: Int[Array, "columns lanes"]
    tried: Int[Array, "columns lanes"]  # candidates of each column used up
    fits: Int[Array, " lanes"]


class _Fitted(NamedTuple):
    """What iteration leaves of each table."""

    assigned: Int[Array, "tables columns"]
    predicted: Float[Array, "tables columns 3"]
    posed: Bool[Array, " tables"]


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
        lanes, following, out, out_fits = state
        row = jnp.minimum(lanes.row, rows - 1)
        request = ranked.request[row]
        there = lanes.assigned != NO_MATCH
        data = flat_points[request[None] * num_points + jnp.maximum(lanes.assigned, 0)].transpose(0, 2, 1)
        fit, predicted, residual = _fit(problems.shape[request].transpose(1, 2, 0), data, there)
        scale = problems.scale[request].T
        error = _score(score, residual, scale, there)
        num_there = jnp.sum(there, axis=0, dtype=jnp.int32)
        done = (error < 1.0) | (num_there <= MIN_FIT_POINTS) | (lanes.row >= rows)
        moved = _replace_worst(lanes, residual / scale, there, table, row)
        target = jnp.where(done, lanes.row, rows)
        posed = (fit.rank >= 2) & (num_there >= MIN_FIT_POINTS)
        found = _Fitted(lanes.assigned.T, predicted.transpose(2, 0, 1), posed)
        out = _Fitted(*(whole.at[target].set(part, mode="drop") for whole, part in zip(out, found)))
        out_fits = out_fits.at[target].set(lanes.fits + 1, mode="drop")
        lanes = _Lanes(
            lanes.row,
            jnp.where(done[None], lanes.assigned, moved.assigned),
            jnp.where(done[None], lanes.tried, moved.tried),
            lanes.fits + 1,
        )
        lanes, following = fill(lanes, done, following)
        return lanes, following, out, out_fits

    nothing = _Lanes(
        jnp.full(num_lanes, rows, jnp.int32),
        jnp.full((columns, num_lanes), NO_MATCH, jnp.int32),
        jnp.zeros((columns, num_lanes), jnp.int32),
        jnp.zeros(num_lanes, jnp.int32),
    )
    lanes, following = fill(nothing, jnp.ones(num_lanes, bool), jnp.int32(0))
    empty = _Fitted(start, jnp.zeros((rows, columns, 3), problems.points.dtype), jnp.zeros(rows, bool))
    state = lanes, following, empty, jnp.zeros(rows, jnp.int32)
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


def _fit(shape, data, there):
    """The rigid fit, where it puts the columns, and their residuals (mm), 0 where there is no match; lanes last."""
    fit = rigid_fit_lanes(shape, data, there.astype(shape.dtype))
    predicted = rotate_lanes(fit.rotation, shape) + fit.translation[None]
    return fit, predicted, jnp.where(there, jnp.sqrt(jnp.sum((predicted - data) ** 2, axis=1)), 0.0)


def _score(score: AbstractMatchScore, residual, scale, there):
    return jax.vmap(score, in_axes=(1, 1, 1))(residual, jnp.maximum(scale, 1e-6), there)


def _finish(problems: Problems, ranked: Hypotheses, fitted: _Fitted, count, score: AbstractMatchScore):
    """Completion by nearest neighbours (Fig. 3), the last fit, and whether Eqs. 4 and 5 hold."""
    rows = len(fitted.posed)

    def body(first, carry):
        request = _rows(ranked.request, first)
        here = _Fitted(*(_rows(field, first) for field in fitted))
        chunk = _finish_chunk(problems, request, here, score)
        return tuple(_put(array, rows, first) for array, rows in zip(carry, chunk))

    empty = (
        jnp.full_like(fitted.assigned, NO_MATCH),
        jnp.zeros(rows, jnp.int32),
        jnp.full(rows, jnp.inf, problems.points.dtype),
        jnp.zeros(rows, bool),
        jnp.zeros(rows, jnp.int32),
    )
    return _by_chunk(count, empty, body)


def _finish_chunk(problems: Problems, request, fitted: _Fitted, score: AbstractMatchScore):
    """`_finish` of some rows; all arrays here have them on the minor axis."""
    assigned, predicted, posed = fitted.assigned.T, fitted.predicted.transpose(1, 2, 0), fitted.posed
    points = problems.points.transpose(2, 0, 1)
    shape = problems.shape[request].transpose(1, 2, 0)
    is_marker = problems.is_marker[request].T
    there = assigned != NO_MATCH
    lost = ~there & is_marker & posed[None]
    wanted = lost & (problems.pinned[request].T == NO_MATCH)
    completed = complete(problems, request, predicted, assigned, wanted)
    there = completed != NO_MATCH
    data = _take(points, request, completed)
    error = _score(score, _fit(shape, data, there)[2], problems.scale[request].T, there)
    error = lax.cond(
        jnp.all(posed),
        lambda error: error,
        lambda error: jnp.where(posed, error, _distance_error(problems, request, data, there)),
        error,
    )
    matched = jnp.sum(there & is_marker, axis=0, dtype=jnp.int32)
    accepted = (error < 1.0) & (matched >= problems.need[request])
    return completed.T, matched, error, accepted, jnp.any(lost, axis=0).astype(jnp.int32)


def _take(points: Float[Array, "3 requests points"], request, assigned) -> Float[Array, "columns 3 lanes"]:
    """Points of each column, lanes last."""
    return points[:, request[None], jnp.maximum(assigned, 0)].transpose(1, 0, 2)


def _distance_error(problems: Problems, request, data, there):
    """Mean error of the matched pair distances over their tolerance, for matches that have no pose."""
    distance, tolerance = problems.distance[request].T, problems.tolerance[request].T

    def add(column, state):
        total, pairs = state
        apart = jnp.sqrt(jnp.sum((data - data[column][None]) ** 2, axis=1))
        error = jnp.abs(apart - distance[column]) / tolerance[column]
        counts = there & there[column][None] & (jnp.arange(len(there)) != column)[:, None]
        total += jnp.sum(jnp.where(counts, error, 0.0), axis=0)
        return total, pairs + jnp.sum(counts, axis=0, dtype=total.dtype)

    nothing = jnp.zeros(request.shape, data.dtype)
    total, pairs = lax.fori_loop(0, len(there), add, (nothing, nothing))
    return total / jnp.maximum(pairs, 1.0)
