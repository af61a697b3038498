"""Candidate tables over every pivot hypothesis (section 4.2.1, Eq. 3); a pure function of padded arrays.

There are far more hypotheses than tables that survive culling. So culling looks at every hypothesis but keeps only the
least cost of each column, hypotheses on the minor axis; candidates are put in order for the survivors alone.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from dshpm_jax._scoring import AbstractCandidateScore
from dshpm_jax._types import NO_MATCH

MAX_CANDIDATES = 6
"""Candidates kept in a column; what lies beyond is counted. A column has this many only in the densest clusters."""

CULL_CHUNK = 1024  # hypotheses culled at a time: their distances to all points stay in the cache
FEW = 8  # of so many hypotheses one survives culling, as a rule; sorting the survivors alone is as much shorter
LAST = jnp.iinfo(jnp.int32).max  # the rank of what does not survive


class Problems(NamedTuple):
    """Segments to match, each among the points of one frame; a leading axis over requests."""

    points: Float[Array, "requests points 3"]
    free: Bool[Array, "requests points"]
    rigid: Bool[Array, "requests points points"]
    pinned: Int[Array, "requests columns"]
    shape: Float[Array, "requests columns 3"]
    distance: Float[Array, "requests columns columns"]
    tolerance: Float[Array, "requests columns columns"]
    scale: Float[Array, "requests columns"]
    reach: Float[Array, "requests columns"]
    is_column: Bool[Array, "requests columns"]
    is_marker: Bool[Array, "requests columns"]
    need: Int[Array, " requests"]


class Hypotheses(NamedTuple):
    """Pivot hypotheses of all requests, one after the other."""

    request: Int[Array, " hypotheses"]
    pivot: Int[Array, " hypotheses"]
    assumed: Int[Array, " hypotheses"]
    valid: Bool[Array, " hypotheses"]


class PivotDistances(NamedTuple):
    """How far points are from each point that may be assumed to be the pivot (mm).

    NaN in `to_point` is a point that no open column may take, in `to_pinned` a column that is not pinned.
    """

    to_point: Float[Array, "requests points points"]
    to_pinned: Float[Array, "requests points columns"]


class Column(NamedTuple):
    """One column of many hypotheses.

    Attributes:
        model_distance, tolerance: of the column from the pivot (mm).
        is_open: whether it takes any free point; others have one point that they are known to be.
        known: that point, `NO_MATCH` where it is no candidate.
        known_cost: its cost, infinite where there is none.
    """

    model_distance: Float[Array, " hypotheses"]
    tolerance: Float[Array, " hypotheses"]
    is_open: Bool[Array, " hypotheses"]
    known: Int[Array, " hypotheses"]
    known_cost: Float[Array, " hypotheses"]


def pivot_distances(problems: Problems) -> PivotDistances:
    """Distances between the points of each request, from which the costs of all its hypotheses follow.

    Our reading: the bounding box is the ball of Eq. 3's farthest column, which Eq. 3 already implies; it needs no test
    of its own.
    """
    requests, num_points, _ = problems.points.shape
    itself = jnp.eye(num_points, dtype=bool)

    def measure(request, distances):
        points, pinned = problems.points[request].T, problems.pinned[request]
        apart = jnp.sqrt(sum((axis[:, None] - axis[None]) ** 2 for axis in points))
        open_to = problems.free[request][None] & problems.rigid[request] & ~itself
        to_pinned = jnp.where(pinned[None] != NO_MATCH, apart[:, pinned], jnp.nan)
        found = PivotDistances(jnp.where(open_to, apart, jnp.nan), to_pinned)
        return PivotDistances(*(whole.at[request].set(part) for whole, part in zip(distances, found)))

    empty = PivotDistances(
        jnp.full((requests, num_points, num_points), jnp.nan, problems.points.dtype),
        jnp.full((requests, num_points, problems.pinned.shape[1]), jnp.nan, problems.points.dtype),
    )
    return lax.fori_loop(0, end_of(jnp.any(problems.is_column, axis=1)), measure, empty)


def end_of(used: Bool[Array, " size"]) -> Int[Array, ""]:
    """The index behind the last that is used: from there on all is padding."""
    return jnp.max(jnp.where(used, jnp.arange(1, len(used) + 1, dtype=jnp.int32), 0))


def _column(
    problems: Problems, distances: PivotDistances, hypotheses: Hypotheses, score: AbstractCandidateScore, column
) -> Column:
    """What one column of each hypothesis is looking for (Eq. 3).

    The pivot's own column holds the assumed pivot alone, a pinned column its known point alone.
    """
    request, pivot, assumed, _ = hypotheses
    model_distance, tolerance = problems.distance[request, pivot, column], problems.tolerance[request, pivot, column]
    pinned, is_column = problems.pinned[request, column], problems.is_column[request, column]
    cost = jax.vmap(score)(model_distance, distances.to_pinned[request, assumed, column], tolerance)
    is_pivot, is_pinned = pivot == column, pinned != NO_MATCH
    fits = is_column & is_pinned & (pinned != assumed) & (cost <= 1.0)
    return Column(
        model_distance,
        tolerance,
        is_column & ~is_pivot & ~is_pinned,
        jnp.where(is_pivot, assumed, jnp.where(fits, pinned, NO_MATCH)),
        jnp.where(is_pivot, 0.0, jnp.where(fits, cost, jnp.inf)),
    )


def _open_costs(score: AbstractCandidateScore, column: Column, data_distance: Float[Array, "points hypotheses"]):
    """Costs of points (at NaN: none) in an open column, infinite where they are no candidates."""
    cost = jax.vmap(jax.vmap(score), in_axes=(None, 0, None))(column.model_distance, data_distance, column.tolerance)
    candidate = column.is_open[None] & ~jnp.isnan(data_distance) & (cost <= 1.0)
    return jnp.where(candidate, cost, jnp.inf)


def rank_tables(
    problems: Problems, distances: PivotDistances, hypotheses: Hypotheses, score: AbstractCandidateScore
) -> tuple[Int[Array, " hypotheses"], Int[Array, ""]]:
    """CT-culling and CT-ranking: the order in which to try the tables, and how many survive.

    A table survives if enough of its columns have candidates for Eq. 5; tables are ordered within their request by
    filled columns, then by summed distance error, ties by index. What does not survive comes last, in any order.
    """
    markers, error = _fill(problems, distances, hypotheses, score)
    survives = hypotheses.valid & (markers >= problems.need[hypotheses.request])
    rank = hypotheses.request * (problems.pinned.shape[1] + 1) - markers
    count = jnp.sum(survives, dtype=jnp.int32)
    return _sort(jnp.where(survives, rank, LAST), error, count), count


def _sort(rank: Int[Array, " hypotheses"], error: Float[Array, " hypotheses"], count) -> Int[Array, " hypotheses"]:
    """Indices by `rank`, then by `error`, then by index; only the first `count`, which are not `LAST`, matter."""
    index = jnp.arange(len(rank), dtype=jnp.int32)
    some = len(rank) // FEW
    survives = rank != LAST
    place = jnp.where(survives, jnp.cumsum(survives, dtype=jnp.int32) - 1, some)

    def sort_survivors(_):
        few = jnp.zeros(some, jnp.int32).at[place].set(index, mode="drop")
        key = jnp.where(jnp.arange(some) < count, rank[few], LAST)
        order = lax.sort((key, error[few], few), num_keys=2)[2]
        return lax.dynamic_update_slice(index, order, (0,))

    def sort_all(_):
        return lax.sort((rank, error, index), num_keys=2)[2]

    return lax.cond(count <= some, sort_survivors, sort_all, None)


def _fill(problems: Problems, distances: PivotDistances, hypotheses: Hypotheses, score: AbstractCandidateScore):
    """How many markers have candidates under each hypothesis, and the summed cost of the best of every column."""
    total = len(hypotheses.pivot)
    size = min(CULL_CHUNK, total)

    def fill(chunk, filled):
        first = chunk * size
        here = Hypotheses(*(lax.dynamic_slice_in_dim(field, first, size) for field in hypotheses))
        found = _fill_chunk(problems, distances, here, score)
        return tuple(lax.dynamic_update_slice_in_dim(whole, part, first, 0) for whole, part in zip(filled, found))

    chunks = -(-end_of(hypotheses.valid) // size)
    return lax.fori_loop(0, chunks, fill, (jnp.zeros(total, jnp.int32), jnp.zeros(total, problems.points.dtype)))


def _fill_chunk(problems: Problems, distances: PivotDistances, hypotheses: Hypotheses, score: AbstractCandidateScore):
    """`_fill` of a chunk: loops over the columns and points that the call really has, however wide its bucket."""
    apart = distances.to_point[hypotheses.request, hypotheses.assumed].T
    num_points, num_columns = end_of(jnp.any(problems.free, axis=0)), end_of(jnp.any(problems.is_column, axis=0))

    def add(number, filled):
        column = _column(problems, distances, hypotheses, score, number)

        def consider(point, least):
            return jnp.minimum(least, _open_costs(score, column, apart[point][None])[0])

        least = lax.fori_loop(0, num_points, consider, column.known_cost)
        markers, error = filled
        there = jnp.isfinite(least)
        markers += (there & problems.is_marker[hypotheses.request, number]).astype(jnp.int32)
        return markers, error + jnp.where(there, least, 0.0)

    nothing = jnp.zeros(apart.shape[1], jnp.int32), jnp.zeros(apart.shape[1], apart.dtype)
    return lax.fori_loop(0, num_columns, add, nothing)


def order_candidates(
    problems: Problems, distances: PivotDistances, hypotheses: Hypotheses, score: AbstractCandidateScore
) -> Int[Array, "columns tables candidates"]:
    """Candidate ordering: the points of each column by cost, ties by index, `NO_MATCH` behind the last."""
    apart = distances.to_point[hypotheses.request, hypotheses.assumed]
    is_first = jnp.arange(MAX_CANDIDATES)[None] == 0

    def order(number, table):
        column = _column(problems, distances, hypotheses, score, number)
        cost = _open_costs(score, column, apart.T).T
        negative, point = lax.top_k(-cost, MAX_CANDIDATES)
        there = jnp.isfinite(negative)
        known = jnp.where(is_first, column.known[:, None], NO_MATCH)
        found = jnp.where(column.is_open[:, None], jnp.where(there, point, NO_MATCH), known)
        return table.at[number].set(found)

    tables, columns = len(apart), problems.pinned.shape[1]
    nothing = jnp.full((columns, tables, MAX_CANDIDATES), NO_MATCH, jnp.int32)
    return lax.fori_loop(0, end_of(jnp.any(problems.is_column, axis=0)), order, nothing)
