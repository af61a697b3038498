"""Evidence for a label at a point, from where the marker's neighbours are: leave-one-out poses, else distances."""

import functools
import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from dshpm_jax._kernels.fusing import all_finite, opaque_true, square_length, stored, total
from dshpm_jax._kernels.rigid_fit import rigid_fit_lanes, rotate_lanes
from dshpm_jax._null_model import NullModel, llr_at_mean
from dshpm_jax._types import MIN_FIT_POINTS


@functools.partial(jax.jit, static_argnames="null")
def life_evidence(
    points: Float[Array, "points 3 lanes"],
    places: Float[Array, "neighbours 3 lanes"],
    shape: Float[Array, "neighbours 3 lanes"],
    own: Float[Array, "3 lanes"],
    distance_sd: Float[Array, "neighbours lanes"],
    marker_sd: Float[Array, " lanes"],
    null: NullModel,
) -> Float[Array, "points lanes"]:
    """Logarithm of how much likelier each point is where it is if it is the marker than if it is none of the model's.

    A lane is one marker in one frame. The evidence comes from the distance to the place that the marker's neighbours
    predict; where these give no pose, from its distances to them. At least `null.min_llr`, which also stands where
    there is no point; `null.unknown_llr` where too few neighbours are known.

    Arguments:
        points: all points of the lane's frame (mm), NaN where there is none.
        places: where the marker's neighbours are in that frame (mm), NaN where unknown.
        shape, own, distance_sd, marker_sd: the marker's neighbourhood, see `LifeEvidence`.
        null: the densities that are compared.
    """
    there = all_finite(places)
    places = jnp.where(there[:, None], places, 0.0)
    predicted, deviation = _predict(null, places, there, shape, own, distance_sd, marker_sd)
    judging = functools.partial(_judge, null)
    judge = stored(opaque_true(marker_sd), judging, places, there, shape, own, distance_sd, predicted, deviation)
    seen = all_finite(points)
    points = jnp.where(seen[:, None], points, 0.0)
    by_pose, by_distance = _by_pose(null, points, judge), _by_distance(null, points, judge.references)
    llr = jnp.where(judge.trusts_pose[None], by_pose, jnp.maximum(by_distance, by_pose))
    unjudged = jnp.where(seen, null.unknown_llr, null.min_llr)
    return jnp.where(seen & judge.known[None], jnp.maximum(llr, null.min_llr), unjudged)


class _References(NamedTuple):
    """The most rigid of a marker's known neighbours, and their parts in the evidence.

    Attributes:
        place: where they are (mm).
        distance: the marker's from them (mm).
        per_sd: one over how much that distance may be off (1/mm); 0 where there is none.
        peak: the evidence where all distances are as expected (nats).
    """

    place: Float[Array, "references 3 lanes"]
    distance: Float[Array, "references lanes"]
    per_sd: Float[Array, "references lanes"]
    peak: Float[Array, " lanes"]


class _Judge(NamedTuple):
    """All that a lane says of its points, whichever they are.

    Attributes:
        known: whether enough neighbours are.
        posed, trusts_pose: whether they give a pose, and whether that says more than distances.
        predicted: the marker's place by that pose (mm).
        axis: how much each coordinate of it may be off (mm).
        peak: the evidence at that place (nats).
    """

    known: Bool[Array, " lanes"]
    posed: Bool[Array, " lanes"]
    trusts_pose: Bool[Array, " lanes"]
    predicted: Float[Array, "3 lanes"]
    axis: Float[Array, " lanes"]
    peak: Float[Array, " lanes"]
    references: _References


def _judge(null: NullModel, places, there, shape, own, distance_sd, predicted, deviation) -> _Judge:
    known = total(there.astype(jnp.int32)) >= null.min_distances
    posed = jnp.isfinite(deviation)
    vague = deviation > null.max_pose_sd_ratio * _second_distance_sd(there, distance_sd)
    axis = jnp.where(posed, deviation / math.sqrt(3.0), 1.0)
    references = _most_rigid(null, places, there, shape, own, distance_sd)
    peak = llr_at_mean(null, jnp.log(axis), 3)
    return _Judge(known, posed, posed & ~vague, predicted, axis, peak, references)


def _second_distance_sd(there: Bool[Array, "neighbours lanes"], distance_sd: Float[Array, "neighbours lanes"]):
    """How much the distance of the second most rigid known neighbour varies (mm)."""
    second = there & (jnp.cumsum(there, axis=0, dtype=jnp.int32) == 2)
    return total(jnp.where(second, distance_sd, 0.0))


def _predict(null: NullModel, places, there, shape, own, distance_sd, marker_sd):
    """Where each marker should be, and how far off that may be (mm), infinite without a pose."""
    base = jnp.where(there, 1.0 / (distance_sd * distance_sd), 0.0)
    weight = base
    for _ in range(null.robust_rounds):
        fit = rigid_fit_lanes(shape, places, weight)
        off = rotate_lanes(fit.rotation, shape) + fit.translation[None] - places
        square = square_length(off) / (null.robust_scale * distance_sd) ** 2
        weight = base / (1.0 + square) ** 2
    fit = rigid_fit_lanes(shape, places, weight)
    place = rotate_lanes(fit.rotation, own[None])[0] + fit.translation
    posed = (fit.rank >= 2) & (total(there.astype(jnp.int32)) >= MIN_FIT_POINTS)
    return place, jnp.where(posed, _deviation(null, shape, own, base, weight, marker_sd), jnp.inf)


def _deviation(null: NullModel, shape, own, base, weight, marker_sd):
    """Standard deviation of a prediction: as learnt with all neighbours, more from fewer and from farther away.

    The leverage of the marker grows with its distance from the neighbours in units of their own extent.
    """
    share = weight / jnp.maximum(total(weight), 1e-12)[None]
    middle = total(share[:, None] * shape)
    extent = total(share * square_length(shape - middle[None]))
    reach = square_length(own - middle)
    typical_sd = jnp.sqrt(1.0 / jnp.maximum(total(base) / len(base), 1e-12))
    lost = 1.0 - total(weight) / jnp.maximum(total(base), 1e-12)
    leverage = reach / jnp.maximum(extent, 1.0)
    few = 1.0 / jnp.maximum(total((share > null.min_weight_share).astype(share.dtype)), 1.0)
    variance = typical_sd**2 * few * (null.leverage_offset + leverage) * null.few_neighbours_variance
    return jnp.sqrt(marker_sd**2 + variance + (lost * marker_sd) ** 2)


def _most_rigid(null: NullModel, places, there, shape, own, distance_sd) -> _References:
    expected = jnp.sqrt(square_length(shape - own[None]))
    order = jnp.where(there, jnp.cumsum(there, axis=0, dtype=jnp.int32), 0)  # neighbours are sorted by it
    chosen = (order[None] == jnp.arange(1, null.max_distances + 1)[:, None, None]).swapaxes(0, 1)
    known = functools.reduce(jnp.logical_or, chosen)
    sd = jnp.where(known, total(jnp.where(chosen, distance_sd[:, None], 0.0)), 1.0)
    return _References(
        total(jnp.where(chosen[:, :, None], places[:, None], 0.0)),
        total(jnp.where(chosen, expected[:, None], 0.0)),
        jnp.where(known, 1.0 / sd, 0.0),
        total(jnp.where(known, llr_at_mean(null, jnp.log(sd), 1), 0.0)) - null.reflection_penalty,
    )


def _by_pose(null: NullModel, points, judge: _Judge):
    """Evidence from how far each point is from the place that the pose predicts."""
    square = square_length(points - judge.predicted[None]) / (null.t_dof * judge.axis * judge.axis)[None]
    return jnp.where(judge.posed[None], judge.peak[None] - 0.5 * (null.t_dof + 3) * jnp.log1p(square), null.min_llr)


def _by_distance(null: NullModel, points, references: _References):
    """Evidence from the distances to the most rigid of the known neighbours."""
    apart = jnp.sqrt(square_length(points[:, None] - references.place[None]))
    error = (apart - references.distance[None]) * references.per_sd[None]
    # One logarithm of the product for all distances: logarithms are what this kernel spends its time on.
    product = functools.reduce(jnp.multiply, (1.0 + error * error / null.t_dof).swapaxes(0, 1))
    return references.peak[None] - 0.5 * (null.t_dof + 1) * jnp.log(product)
