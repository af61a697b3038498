"""Evidence for a label at a point, from where the marker's neighbours are: leave-one-out poses, else distances."""

import math

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

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
    there = jnp.isfinite(places).all(1)
    places = jnp.where(there[:, None], places, 0.0)
    predicted, deviation = _predict(places, there, shape, own, softness, spread)
    seen = jnp.isfinite(points).all(1)
    points = jnp.where(seen[:, None], points, 0.0)
    posed = jnp.isfinite(deviation)
    axis = jnp.where(posed, deviation / math.sqrt(3.0), 1.0)  # of one coordinate
    apart = points - predicted[None]
    by_pose = jnp.where(posed[None], _log_ratio(jnp.sum(apart * apart, axis=1), axis[None], 3), WORST)
    by_distance = _by_distance(points, places, there, shape, own, softness)
    vague = deviation > VAGUE * _second_softness(there, softness)
    evidence = jnp.where((posed & ~vague)[None], by_pose, jnp.maximum(by_distance, by_pose))
    known = jnp.sum(there, axis=0) >= MIN_DISTANCES
    return jnp.where(seen & known[None], jnp.maximum(evidence, WORST), jnp.where(seen, UNKNOWN, WORST))


def _second_softness(there: Bool[Array, "neighbours lanes"], softness: Float[Array, "neighbours lanes"]):
    """Softness of the second most rigid known neighbour (mm)."""
    second = there & (jnp.cumsum(there, axis=0, dtype=jnp.int32) == 2)
    return jnp.sum(jnp.where(second, softness, 0.0), axis=0)


def _log_ratio(square, deviation, dimensions: int):
    """Log ratio of a t density of `dimensions` to the uniform background, for a squared distance."""
    fall = 0.5 * (TAIL + dimensions) * jnp.log1p(square / (TAIL * deviation * deviation))
    return _log_peak(deviation, dimensions) - fall


def _log_peak(deviation, dimensions: int):
    """`_log_ratio` at distance zero."""
    peak = math.lgamma((TAIL + dimensions) / 2) - math.lgamma(TAIL / 2) - 0.5 * dimensions * math.log(TAIL * math.pi)
    return peak + dimensions * (BACKGROUND - jnp.log(deviation))


def _predict(places, there, shape, own, softness, spread):
    """Where each marker should be, and how far off that may be (mm), infinite without a pose."""
    base = jnp.where(there, 1.0 / (softness * softness), 0.0)
    weight = base
    for _ in range(ROBUST_ROUNDS):
        fit = rigid_fit_lanes(shape, places, weight)
        off = rotate_lanes(fit.rotation, shape) + fit.translation[None] - places
        square = jnp.sum(off * off, axis=1) / (ROBUST_SCALE * softness) ** 2
        weight = base / (1.0 + square) ** 2
    fit = rigid_fit_lanes(shape, places, weight)
    place = rotate_lanes(fit.rotation, own[None])[0] + fit.translation
    posed = (fit.rank >= 2) & (jnp.sum(there, axis=0) >= MIN_FIT_POINTS)
    return place, jnp.where(posed, _deviation(shape, own, base, weight, spread), jnp.inf)


def _deviation(shape, own, base, weight, spread):
    """Standard deviation of a prediction: as learnt with all neighbours, more from fewer and from farther away.

    The leverage of the marker grows with its distance from the neighbours in units of their own extent.
    """
    share = weight / jnp.maximum(jnp.sum(weight, axis=0), 1e-12)[None]
    middle = jnp.sum(share[:, None] * shape, axis=0)
    extent = jnp.sum(share * jnp.sum((shape - middle[None]) ** 2, axis=1), axis=0)
    reach = jnp.sum((own - middle) ** 2, axis=0)
    softness = jnp.sqrt(1.0 / jnp.maximum(jnp.mean(base, axis=0), 1e-12))
    lost = 1.0 - jnp.sum(weight, axis=0) / jnp.maximum(jnp.sum(base, axis=0), 1e-12)
    leverage = reach / jnp.maximum(extent, 1.0)
    few = 1.0 / jnp.maximum(jnp.sum(share > 0.02, axis=0, dtype=share.dtype), 1.0)
    return jnp.sqrt(spread**2 + softness**2 * few * (0.5 + leverage) * 0.5 + (lost * spread) ** 2)


def _by_distance(points, places, there, shape, own, softness):
    """Evidence from the distances to the three most rigid of the known neighbours."""
    expected = jnp.sqrt(jnp.sum((shape - own[None]) ** 2, axis=1))
    order = jnp.where(there, jnp.cumsum(there, axis=0, dtype=jnp.int32), 0)  # neighbours are sorted by softness
    peak = jnp.full(there.shape[1], -MIRROR, points.dtype)
    spread = jnp.ones((points.shape[0], there.shape[1]), points.dtype)
    for rank in range(1, MAX_DISTANCES + 1):
        chosen = order == rank
        known = jnp.any(chosen, axis=0)
        place = jnp.sum(jnp.where(chosen[:, None], places, 0.0), axis=0)
        distance = jnp.sum(jnp.where(chosen, expected, 0.0), axis=0)
        soft = jnp.where(known, jnp.sum(jnp.where(chosen, softness, 0.0), axis=0), 1.0)
        apart = points - place[None]
        error = (jnp.sqrt(jnp.sum(apart * apart, axis=1)) - distance[None]) / soft[None]
        # One logarithm of the product for all distances: logarithms are what this kernel spends its time on.
        spread *= jnp.where(known[None], 1.0 + error * error / TAIL, 1.0)
        peak += jnp.where(known, _log_peak(soft, 1), 0.0)
    return peak[None] - 0.5 * (TAIL + 1) * jnp.log(spread)
