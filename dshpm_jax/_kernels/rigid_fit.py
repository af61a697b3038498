"""The weighted rigid fit: rotation and translation that carry model markers onto observed points.

Every hypothesis of section 4.2.2 costs one such fit, so it is made of few passes over arrays whose minor axis is the
hypothesis ("lanes"). The 3 x 3 covariance is diagonalised by one-sided Jacobi rotations: accurate near rank 1, without
branches, and never NaN.
"""

import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

MIN_SPREAD = 12.0
"""Millimetres (RMS) that points must spread along an axis for the axis to count towards the rank."""

FARTHEST = 1e9
"""Millimetres; coordinates that sum to more, or to NaN, are no measurement and are left out of the fit."""

NUM_SWEEPS = 3  # Jacobi converges quadratically: after three sweeps of a 3 x 3 matrix float32 has nothing left to gain
NUM_STEPS = 3 * NUM_SWEEPS  # a sweep rotates each of the three pairs of columns once
CHUNK_LANES = 2048  # more lanes at once spill the intermediate arrays from the cache
NEGLIGIBLE = 1e-6  # a singular value under this share of the largest is rounding and has no direction of its own

_Lanes = Float[Array, "lanes"]
_Vectors = Float[Array, "3 lanes"]
_Columns = tuple[Float[Array, "6 lanes"], Float[Array, "6 lanes"], Float[Array, "6 lanes"]]


class RigidFit(NamedTuple):
    """`points ~ rotation @ model + translation`, in the layout (lanes last or batch first) of the call that made it.

    Attributes:
        rotation: orthonormal with determinant +1, whatever the input.
        translation: millimetres.
        rms: weighted root mean square of the residuals in millimetres; 0 where nothing has weight.
        rank: in how many directions, 0 to 3, the matched points spread; the rotation is meaningful from 2 on.
    """

    rotation: Float[Array, "*batch 3 3"]
    translation: Float[Array, "*batch 3"]
    rms: Float[Array, "*batch"]
    rank: Int[Array, "*batch"]


def rigid_fit(
    model: Float[Array, "*batch markers 3"],
    data: Float[Array, "*batch markers 3"],
    weights: Float[Array, "*batch markers"],
    min_spread: float = MIN_SPREAD,
) -> RigidFit:
    """Least-squares rigid fit of `model` to `data` for each element of a batch (section 4.2.2).

    Arguments:
        model, data: corresponding positions in millimetres; batch axes broadcast.
        weights: not negative; 0 for padding and for what is missing, where NaN does no harm.
        min_spread: see `rigid_fit_lanes`.

    Our reading: the paper's "affine" map is a rotation and a translation, without reflection.
    """
    batch = jnp.broadcast_shapes(model.shape[:-2], data.shape[:-2], weights.shape[:-1])
    markers = weights.shape[-1]
    lanes = math.prod(batch)
    model, data = (
        jnp.moveaxis(jnp.broadcast_to(x, (*batch, markers, 3)).reshape(lanes, markers, 3), 0, -1) for x in (model, data)
    )
    weights = jnp.broadcast_to(weights, (*batch, markers)).reshape(lanes, markers).T
    fit = _in_chunks(model, data, weights, min_spread)
    return RigidFit(*(jnp.moveaxis(x, -1, 0).reshape(*batch, *x.shape[:-1]) for x in fit))


def rigid_fit_lanes(
    model: Float[Array, "markers 3 lanes"],
    data: Float[Array, "markers 3 lanes"],
    weights: Float[Array, "markers lanes"],
    min_spread: float = MIN_SPREAD,
) -> RigidFit:
    """`rigid_fit` with the hypotheses on the minor axis, for use inside other kernels' loops.

    Returns rotation (3, 3, lanes), translation (3, lanes), rms (lanes,) and rank (lanes,). The rank counts the
    singular values of the weighted covariance of model and data that exceed `min_spread` squared.

    Our reading: under 3 points or a second singular value below 12 mm RMS there is no pose; the rank is then below 2.
    """
    used = (weights > 0) & (jnp.abs(model).sum(1) + jnp.abs(data).sum(1) < FARTHEST)
    model, data = (jnp.where(used[:, None], x, 0) for x in (model, data))
    weights = jnp.where(used, weights, 0)
    total = _total(weights)
    share = (weights / jnp.where(total > 0, total, 1)[None])[:, None]
    model_mean, data_mean = _total(share * model), _total(share * data)
    model, data = (jnp.where(used[:, None], x - mean[None], 0) for x, mean in ((model, model_mean), (data, data_mean)))
    covariance = _total(share[:, None] * data[:, :, None] * model[:, None])
    rotation, spread = _nearest_rotation(covariance)
    residuals = data - rotate_lanes(rotation, model)
    # The means are rounded at the size of the coordinates, the residuals only at their own: what is left is put right.
    left = _total(share * residuals)
    translation = data_mean + left - rotate_lanes(rotation, model_mean[None])[0]
    square = _total(share * residuals**2) - left**2
    rank = (spread >= min_spread**2).sum(0, dtype=jnp.int32)
    return RigidFit(rotation, translation, jnp.sqrt(jnp.maximum(square.sum(0), 0)), rank)


def rotate_lanes(
    rotation: Float[Array, "3 3 lanes"], points: Float[Array, "markers 3 lanes"]
) -> Float[Array, "markers 3 lanes"]:
    """Each lane's points turned by its rotation."""
    return sum(rotation[None, :, k] * points[:, None, k] for k in range(3))  # pyright: ignore


def _in_chunks(model, data, weights, min_spread) -> RigidFit:
    """`rigid_fit_lanes` over chunks that stay in the cache."""
    lanes = weights.shape[-1]
    if lanes <= CHUNK_LANES:
        return rigid_fit_lanes(model, data, weights, min_spread)
    chunks = -(-lanes // CHUNK_LANES)

    def split(x):
        padded = jnp.pad(x, [(0, 0)] * (x.ndim - 1) + [(0, chunks * CHUNK_LANES - lanes)])
        return jnp.moveaxis(padded.reshape(*x.shape[:-1], chunks, CHUNK_LANES), -2, 0)

    fit = jax.lax.map(lambda xs: rigid_fit_lanes(*xs, min_spread), (split(model), split(data), split(weights)))
    return RigidFit(*(jnp.moveaxis(x, 0, -2).reshape(*x.shape[1:-1], -1)[..., :lanes] for x in fit))


def _total(x: Float[Array, "markers *rest"]) -> Float[Array, "*rest"]:
    """Sum over the short leading axis, unrolled so that XLA fuses it with what it sums."""
    return sum(x[i] for i in range(1, x.shape[0])) + x[0]  # pyright: ignore


def _nearest_rotation(
    covariance: Float[Array, "3 3 lanes"],
) -> tuple[Float[Array, "3 3 lanes"], Float[Array, "3 lanes"]]:
    """The rotation R that maximises trace(R^T covariance), and the singular values of the covariance, unsorted.

    With covariance = U S V^T, R = u1 v1^T + u2 v2^T + (u1 x u2)(v1 x v2)^T from the two dominant pairs: the third pair
    is the cross product, so the determinant is +1 for mirrored and for flat point sets alike.
    """
    scale = jnp.abs(covariance).max((0, 1))
    first, second, third, gram = _orthogonal_columns(covariance / jnp.where(scale > 0, scale, 1)[None, None])
    # Compared as they left the loop: see `_orthogonal_columns` on ties. The second pair follows the first cyclically,
    # so the choice is an even permutation.
    dropped = jnp.argmin(gram[:3], axis=0)[None]
    a = jnp.where(dropped == 0, second, jnp.where(dropped == 1, third, first))
    b = jnp.where(dropped == 0, third, jnp.where(dropped == 1, first, second))
    norms = jnp.sqrt(gram[:3])
    a_norm = jnp.where(dropped[0] == 0, norms[1], jnp.where(dropped[0] == 1, norms[2], norms[0]))
    b_norm = jnp.where(dropped[0] == 0, norms[2], jnp.where(dropped[0] == 1, norms[0], norms[1]))
    u1, u2 = _orthonormal(a[:3], b[:3], a_norm, b_norm)
    v1, v2 = a[3:], b[3:]
    pairs = ((u1, v1), (u2, v2), (_cross(u1, u2), _cross(v1, v2)))
    return sum(u[:, None] * v[None] for u, v in pairs), norms * scale[None]  # pyright: ignore


def _orthogonal_columns(matrix: Float[Array, "3 3 lanes"]) -> tuple[*_Columns, Float[Array, "4 lanes"]]:
    """Rotates the columns of `matrix` until they are orthogonal (one-sided Jacobi).

    Returns three columns, each the column of `matrix @ V` above that of `V`, and their `_gram`.

    A step must turn the matrix and V by the same angle, but XLA computes a shared value once in each fusion that needs
    it, rounds the copies differently, and the two senses of a turn by 45 degrees are an exact tie in symmetric input.
    So the numbers that a step decides by are state of the loop: stored once, and compared without arithmetic.
    """

    def step(_, state):
        first, second, third, gram = state
        c, s = _turn(gram)
        first, second = c[None] * first - s[None] * second, s[None] * first + c[None] * second
        return second, third, first, _gram(second, third, first)  # the next pair comes to the front

    identity = jnp.broadcast_to(jnp.eye(3, dtype=matrix.dtype)[:, :, None], matrix.shape)
    stacked = jnp.concatenate([matrix, identity])
    columns = stacked[:, 0], stacked[:, 1], stacked[:, 2]
    return jax.lax.fori_loop(0, NUM_STEPS, step, (*columns, _gram(*columns)))


def _gram(first, second, third) -> Float[Array, "4 lanes"]:
    """Squared lengths of the three columns, and the product of the first two."""
    pairs = ((first, first), (second, second), (third, third), (first, second))
    return jnp.stack([a[0] * b[0] + a[1] * b[1] + a[2] * b[2] for a, b in pairs])


def _turn(gram: Float[Array, "4 lanes"]) -> tuple[_Lanes, _Lanes]:
    """Cosine and sine of the smaller of the two turns that make the first two columns orthogonal."""
    difference, product = gram[1] - gram[0], 2 * gram[3]
    # tan of the angle, from the smaller root of t^2 + 2 zeta t - 1 = 0 with zeta = difference / product
    size = jnp.abs(difference) + jnp.sqrt(difference**2 + product**2)
    t = jnp.where(gram[1] >= gram[0], product, -product) / jnp.where(size > 0, size, 1)
    c = jax.lax.rsqrt(1 + t * t)
    return c, c * t


def _orthonormal(a: _Vectors, b: _Vectors, a_norm: _Lanes, b_norm: _Lanes) -> tuple[_Vectors, _Vectors]:
    """Unit vectors along `a` and `b`, which are orthogonal but for rounding; any that serve where these vanish."""
    swap = b_norm > a_norm
    long, short = jnp.where(swap[None], b, a), jnp.where(swap[None], a, b)
    long_norm, short_norm = jnp.maximum(a_norm, b_norm), jnp.minimum(a_norm, b_norm)
    axis = jnp.array([1, 0, 0], dtype=a.dtype)[:, None]
    first = jnp.where(long_norm[None] > 0, long / jnp.where(long_norm > 0, long_norm, 1)[None], axis)
    clear = short_norm > NEGLIGIBLE * long_norm
    second = short / jnp.where(clear, short_norm, 1)[None]
    second = second - (first * second).sum(0)[None] * first
    length = jnp.sqrt((second**2).sum(0))
    clear &= length > 0.5
    second = jnp.where(clear[None], second / jnp.where(clear, length, 1)[None], _perpendicular(first))
    return jnp.where(swap[None], second, first), jnp.where(swap[None], first, second)


def _perpendicular(unit: _Vectors) -> _Vectors:
    """A unit vector at right angles to `unit`, without a branch that rounding could tip."""
    x, y, z = unit
    sign = jnp.where(z < 0, -1, 1).astype(unit.dtype)  # only -z or z in the divisor, which stays at least 1 in size
    a = -1 / (sign + z)
    return jnp.stack([1 + sign * x * x * a, sign * x * y * a, -sign * x])


def _cross(a: _Vectors, b: _Vectors) -> _Vectors:
    return jnp.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
