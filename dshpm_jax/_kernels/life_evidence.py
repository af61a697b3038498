"""Evidence for a label at a point, from where the marker's neighbours are: leave-one-out poses, else distances."""

import functools
import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from dshpm_jax._kernels.fusing import all_finite, opaque_true, square_length, stored, total
from dshpm_jax._kernels.rigid_fit import rigid_fit_lanes, rotate_lanes
from dshpm_jax._types import MIN_FIT_POINTS

TAIL = 3.0  # degrees of freedom of the errors' t distribution: soft tissue has heavy tails
BACKGROUND = math.log(700.0)  # of mm; a point that is no marker of the model may be anywhere in a body's volume
WORST = -12.0  # nats; beyond, wrong is wrong, so that a few bad frames do not condemn a life
UNKNOWN = 0.0  # nats, where nothing speaks for the label or against it
ROBUST_ROUNDS = 2  # reweighted fits after the first
ROBUST_SCALE = 2.0  # a neighbour that misses by so many times its softness counts a quarter
VAGUE = 3.0  # a pose that is so many times softer than the second neighbour turns about a line: distances say more
MIRROR = math.log(2.0)  # distances alone cannot tell a point from its mirror image
MIN_DISTANCES = 2  # fewer known neighbours say nothing
MAX_DISTANCES = 3  # a point has three coordinates, however many distances are known


@jax.jit
def life_evidence(
    points: Float[Array, "points 3 lanes"],
    places: Float[Array, "neighbours 3 lanes"],
    shape: Float[Array, "neighbours 3 lanes"],
    own: Float[Array, "3 lanes"],
    softness: Float[Array, "neighbours lanes"],
    spread: Float[Array, " lanes"],
) -> Float[Array, "points lanes"]:
    """Logarithm of how much likelier each point is where it is if it is the marker than if it is none of the model's.

    A lane is one marker in one frame. The evidence comes from the distance to the place that the marker's neighbours
    predict; where these give no pose, from its distances to them. At least `WORST`, which also stands where there is
    no point; `UNKNOWN` where fewer than two neighbours are known.

    Arguments:
        points: all points of the lane's frame (mm), NaN where there is none.
        places: where the marker's neighbours are in that frame (mm), NaN where unknown.
        shape, own, softness, spread: the marker's neighbourhood, see `LifeEvidence`.
    """
    there = all_finite(places)
    places = jnp.where(there[:, None], places, 0.0)
    predicted, deviation = _predict(places, there, shape, own, softness, spread)
    judge = stored(opaque_true(spread), _judge, places, there, shape, own, softness, predicted, deviation)
    seen = all_finite(points)
    points = jnp.where(seen[:, None], points, 0.0)
    by_pose, by_distance = _by_pose(points, judge), _by_distance(points, judge.references)
    evidence = jnp.where(judge.trusts_pose[None], by_pose, jnp.maximum(by_distance, by_pose))
    return jnp.where(seen & judge.known[None], jnp.maximum(evidence, WORST), jnp.where(seen, UNKNOWN, WORST))


class _References(NamedTuple):
    """The most rigid of a marker's known neighbours, and their parts in the evidence.

    Attributes:
        place: where they are (mm).
        distance: the marker's from them (mm).
        per_softness: one over how much that distance may be off (1/mm); 0 where there is none.
        peak: the evidence where all distances are as expected (nats).
    """

    place: Float[Array, "references 3 lanes"]
    distance: Float[Array, "references lanes"]
    per_softness: Float[Array, "references lanes"]
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


def _judge(places, there, shape, own, softness, predicted, deviation) -> _Judge:
    known = total(there.astype(jnp.int32)) >= MIN_DISTANCES
    posed = jnp.isfinite(deviation)
    vague = deviation > VAGUE * _second_softness(there, softness)
    axis = jnp.where(posed, deviation / math.sqrt(3.0), 1.0)
    references = _most_rigid(places, there, shape, own, softness)
    return _Judge(known, posed, posed & ~vague, predicted, axis, _log_peak(axis, 3), references)


def _second_softness(there: Bool[Array, "neighbours lanes"], softness: Float[Array, "neighbours lanes"]):
    """Softness of the second most rigid known neighbour (mm)."""
    second = there & (jnp.cumsum(there, axis=0, dtype=jnp.int32) == 2)
    return total(jnp.where(second, softness, 0.0))


def _log_peak(deviation, dimensions: int):
    """Log ratio of a t density of `dimensions` to the uniform background, at distance zero."""
    peak = math.lgamma((TAIL + dimensions) / 2) - math.lgamma(TAIL / 2) - 0.5 * dimensions * math.log(TAIL * math.pi)
    return peak + dimensions * (BACKGROUND - jnp.log(deviation))


def _predict(places, there, shape, own, softness, spread):
    """Where each marker should be, and how far off that may be (mm), infinite without a pose."""
    base = jnp.where(there, 1.0 / (softness * softness), 0.0)
    weight = base
    for _ in range(ROBUST_ROUNDS):
        fit = rigid_fit_lanes(shape, places, weight)
        off = rotate_lanes(fit.rotation, shape) + fit.translation[None] - places
        square = square_length(off) / (ROBUST_SCALE * softness) ** 2
        weight = base / (1.0 + square) ** 2
    fit = rigid_fit_lanes(shape, places, weight)
    place = rotate_lanes(fit.rotation, own[None])[0] + fit.translation
    posed = (fit.rank >= 2) & (total(there.astype(jnp.int32)) >= MIN_FIT_POINTS)
    return place, jnp.where(posed, _deviation(shape, own, base, weight, spread), jnp.inf)


def _deviation(shape, own, base, weight, spread):
    """Standard deviation of a prediction: as learnt with all neighbours, more from fewer and from farther away.

    The leverage of the marker grows with its distance from the neighbours in units of their own extent.
    """
    share = weight / jnp.maximum(total(weight), 1e-12)[None]
    middle = total(share[:, None] * shape)
    extent = total(share * square_length(shape - middle[None]))
    reach = square_length(own - middle)
    softness = jnp.sqrt(1.0 / jnp.maximum(total(base) / len(base), 1e-12))
    lost = 1.0 - total(weight) / jnp.maximum(total(base), 1e-12)
    leverage = reach / jnp.maximum(extent, 1.0)
    few = 1.0 / jnp.maximum(total((share > 0.02).astype(share.dtype)), 1.0)
    return jnp.sqrt(spread**2 + softness**2 * few * (0.5 + leverage) * 0.5 + (lost * spread) ** 2)


def _most_rigid(places, there, shape, own, softness) -> _References:
    expected = jnp.sqrt(square_length(shape - own[None]))
    order = jnp.where(there, jnp.cumsum(there, axis=0, dtype=jnp.int32), 0)  # neighbours are sorted by softness
    chosen = (order[None] == jnp.arange(1, MAX_DISTANCES + 1)[:, None, None]).swapaxes(0, 1)
    known = functools.reduce(jnp.logical_or, chosen)
    soft = jnp.where(known, total(jnp.where(chosen, softness[:, None], 0.0)), 1.0)
    return _References(
        total(jnp.where(chosen[:, :, None], places[:, None], 0.0)),
        total(jnp.where(chosen, expected[:, None], 0.0)),
        jnp.where(known, 1.0 / soft, 0.0),
        total(jnp.where(known, _log_peak(soft, 1), 0.0)) - MIRROR,
    )


def _by_pose(points, judge: _Judge):
    """Evidence from how far each point is from the place that the pose predicts."""
    square = square_length(points - judge.predicted[None]) / (TAIL * judge.axis * judge.axis)[None]
    return jnp.where(judge.posed[None], judge.peak[None] - 0.5 * (TAIL + 3) * jnp.log1p(square), WORST)


def _by_distance(points, references: _References):
    """Evidence from the distances to the most rigid of the known neighbours."""
    apart = jnp.sqrt(square_length(points[:, None] - references.place[None]))
    error = (apart - references.distance[None]) * references.per_softness[None]
    # One logarithm of the product for all distances: logarithms are what this kernel spends its time on.
    spread = functools.reduce(jnp.multiply, (1.0 + error * error / TAIL).swapaxes(0, 1))
    return references.peak[None] - 0.5 * (TAIL + 1) * jnp.log(spread)
