"""Candidate tables over every pivot hypothesis (section 4.2.1, Eq. 3); a pure function of padded arrays."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from dshpm_jax._scoring import AbstractCandidateScore
from dshpm_jax._types import NO_MATCH

MAX_CANDIDATES = 6
"""Candidates kept in a column; what lies beyond is counted. A column has this many only in the densest clusters."""


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


def candidate_costs(
    problems: Problems, hypotheses: Hypotheses, score: AbstractCandidateScore
) -> Float[Array, "hypotheses columns points"]:
    """Cost of every point in every column under every hypothesis, infinite where it is no candidate (Eq. 3).

    The pivot's own column holds the assumed pivot alone, a pinned column its known point alone.

    Our reading: the bounding box is the ball of Eq. 3's farthest column, which Eq. 3 already implies; it needs no test
    of its own.
    """
    request, pivot, assumed, _ = hypotheses
    points = problems.points[request]
    apart = points - jnp.take_along_axis(points, assumed[:, None, None], axis=1)
    data_distance = jnp.sqrt(jnp.sum(apart * apart, axis=-1))
    model_distance, tolerance = problems.distance[request, pivot], problems.tolerance[request, pivot]
    over_points = jax.vmap(score, in_axes=(None, 0, None))
    over_columns = jax.vmap(over_points, in_axes=(0, None, 0))
    cost = jax.vmap(over_columns)(model_distance, data_distance, tolerance)
    column = jnp.arange(cost.shape[1])[None, :]
    point = jnp.arange(cost.shape[2])[None, :]
    is_assumed = (point == assumed[:, None])[:, None, :]
    is_pivot = (column == pivot[:, None])[:, :, None]
    pinned = problems.pinned[request][:, :, None]
    allowed = (problems.free[request] & problems.rigid[request, assumed])[:, None, :]
    allowed = jnp.where(pinned == NO_MATCH, allowed, point[:, None] == pinned)
    candidate = allowed & ~is_assumed & ~is_pivot & (cost <= 1.0)
    candidate &= problems.is_column[request][:, :, None]
    return jnp.where(is_pivot & is_assumed, 0.0, jnp.where(candidate, cost, jnp.inf))


def rank_tables(
    problems: Problems, hypotheses: Hypotheses, cost: Float[Array, "hypotheses columns points"]
) -> tuple[Int[Array, " hypotheses"], Int[Array, ""]]:
    """CT-culling and CT-ranking: the order in which to try the tables, and how many survive.

    A table survives if enough of its columns have candidates for Eq. 5; tables are ordered within their request by
    filled columns, then by summed distance error.
    """
    best = jnp.min(cost, axis=2)
    filled = jnp.isfinite(best)
    markers = jnp.sum(filled & problems.is_marker[hypotheses.request], axis=1, dtype=jnp.int32)
    error = jnp.sum(jnp.where(filled, best, 0.0), axis=1)
    survives = hypotheses.valid & (markers >= problems.need[hypotheses.request])
    order = jnp.lexsort((error, -markers, hypotheses.request, ~survives))
    return order.astype(jnp.int32), jnp.sum(survives, dtype=jnp.int32)


def order_candidates(
    cost: Float[Array, "tables columns points"],
) -> tuple[Int[Array, "tables columns candidates"], Int[Array, ""]]:
    """Candidate ordering: the points of each column by cost, ties by index, `NO_MATCH` behind the last.

    Also how many candidates had to be left out.
    """
    total = jnp.sum(jnp.isfinite(cost), dtype=jnp.int32)
    point = jnp.arange(cost.shape[2], dtype=jnp.int32)[None, None]
    found = []
    for _ in range(MAX_CANDIDATES):
        next_best = jnp.argmin(cost, axis=2).astype(jnp.int32)
        is_next = point == next_best[:, :, None]
        there = jnp.any(is_next & jnp.isfinite(cost), axis=2)
        found.append(jnp.where(there, next_best, NO_MATCH))
        cost = jnp.where(is_next, jnp.inf, cost)
    table = jnp.stack(found, axis=-1)
    return table, total - jnp.sum(table != NO_MATCH, dtype=jnp.int32)
