"""The weighted rigid fit: rotation and translation that carry model markers onto observed points.

Every hypothesis of section 4.2.2 costs one such fit, so it is made of few passes over arrays whose minor axis is the
hypothesis ("lanes"). One-sided Jacobi rotations of the 3 x 3 covariance give its dominant pair of singular vectors; the
best rotation carries one to the other, and the turn about that axis is a fit in the plane, in closed form. So the
determinant is +1 for mirrored and for flat point sets alike, points near a line lose no accuracy, and nothing is ever
NaN.
"""

import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from dshpm_jax._kernels.fusing import opaque_true, stored, total

MIN_SPREAD = 12.0
"""Millimetres (RMS) that points must spread along an axis for the axis to count towards the rank."""

FARTHEST = 1e9
"""Millimetres; coordinates that sum to more, or to NaN, are no measurement and are left out of the fit."""

NUM_SWEEPS = 3  # Jacobi converges quadratically: after three sweeps of a 3 x 3 matrix float32 has nothing left to gain
NUM_STEPS = 3 * NUM_SWEEPS  # a sweep rotates each of the three pairs of columns once
CHUNK_LANES = 1024  # more lanes at once spill the intermediate arrays from the cache

_Lanes = Float[Array, "lanes"]
_Vectors = Float[Array, "3 lanes"]
_Frame = tuple[_Vectors, _Vectors, _Vectors]
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


class _Points(NamedTuple):
    """What is fitted to what, and its weighted means."""

    model: Float[Array, "markers 3 lanes"]
    data: Float[Array, "markers 3 lanes"]
    weights: Float[Array, "markers lanes"]
    model_mean: _Vectors
    data_mean: _Vectors


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

    def lanes_last(x):
        return jnp.moveaxis(jnp.broadcast_to(x, (*batch, markers, 3)).reshape(lanes, markers, 3), 0, -1)

    weights = jnp.broadcast_to(weights, (*batch, markers)).reshape(lanes, markers).T
    fit = _in_chunks(lanes_last(model), lanes_last(data), weights, min_spread)
    return RigidFit(*(jnp.moveaxis(x, -1, 0).reshape(*batch, *x.shape[:-1]) for x in fit))


@jax.jit  # so that kernels which use it several times trace it once
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
    weights = _usable(model, data, weights)
    always = opaque_true(weights)
    per_weight, model_mean, data_mean = stored(always, _means, model, data, weights)
    points = _Points(model, data, weights, model_mean, data_mean)
    u, v, spread = _dominant_pair(stored(always, _covariance, points, per_weight))
    frames = stored(always, _frames, u, v)
    # The covariance holds squares, so a spread of 1e-4 of the largest drowns in its rounding; the points still show it.
    rotation = stored(always, _turned, frames, stored(always, _sides_of_turn, points, frames))
    left, square = stored(always, _residuals, points, rotation, per_weight)
    # The means are rounded at the size of the coordinates, the residuals only at their own: what is left is put right.
    translation = data_mean + (left - rotate_lanes(rotation, model_mean[None])[0])
    rms = jnp.sqrt(jnp.maximum(total(square - left**2), 0))
    return RigidFit(rotation, translation, rms, (spread >= min_spread**2).sum(0, dtype=jnp.int32))


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

    def fit_chunk(chunk):
        model, data, weights = chunk
        return rigid_fit_lanes(model, data, weights, min_spread)

    fit = jax.lax.map(fit_chunk, (split(model), split(data), split(weights)))
    return RigidFit(*(jnp.moveaxis(x, 0, -2).reshape(*x.shape[1:-1], -1)[..., :lanes] for x in fit))


def _usable(model, data, weights) -> Float[Array, "markers lanes"]:
    """The weights, 0 wherever a marker has none or no finite position."""
    size = sum(jnp.abs(x[:, k]) for x in (model, data) for k in range(3))
    return jnp.where((weights > 0) & (size < FARTHEST), weights, 0)


def _means(model, data, weights) -> tuple[_Lanes, _Vectors, _Vectors]:
    """One over the sum of the weights (1 where that is 0), and the weighted means of model and data."""
    weight = total(weights)
    per_weight = 1 / jnp.where(weight > 0, weight, 1)
    used = (weights > 0)[:, None]
    model, data = (total(weights[:, None] * jnp.where(used, x, 0)) * per_weight[None] for x in (model, data))
    return per_weight, model, data


def _centred(points: _Points) -> tuple[Float[Array, "markers 3 lanes"], Float[Array, "markers 3 lanes"]]:
    """Model and data from their means, 0 where nothing has weight."""
    used = (points.weights > 0)[:, None]
    model, data = points.model - points.model_mean[None], points.data - points.data_mean[None]
    return jnp.where(used, model, 0), jnp.where(used, data, 0)


def _covariance(points: _Points, per_weight: _Lanes) -> Float[Array, "3 3 lanes"]:
    model, data = _centred(points)
    return total((points.weights[:, None] * data)[:, :, None] * model[:, None]) * per_weight[None, None]


def _frames(u: _Vectors, v: _Vectors) -> tuple[_Frame, _Frame]:
    """Axes of data and of model, of which the rotation carries the first ones into each other."""
    return (u, *_perpendiculars(u)), (v, *_perpendiculars(v))


def _sides_of_turn(points: _Points, frames: tuple[_Frame, _Frame]) -> tuple[_Lanes, _Lanes]:
    """Adjacent and opposite side of the best turn about the first axis, a fit in the plane."""
    (_, u2, u3), (_, v2, v3) = frames
    model, data = (x.swapaxes(0, 1) for x in _centred(points))
    m2, m3, d2, d3 = (_dot(axis[:, None], x) for axis, x in ((v2, model), (v3, model), (u2, data), (u3, data)))
    return total(points.weights * (m2 * d2 + m3 * d3)), total(points.weights * (m2 * d3 - m3 * d2))


def _turned(frames: tuple[_Frame, _Frame], sides: tuple[_Lanes, _Lanes]) -> Float[Array, "3 3 lanes"]:
    """The rotation that carries the model's first axis to the data's and turns the others by the angle of `sides`."""
    (u, u2, u3), (v, v2, v3) = frames
    c, s = _cosine_and_sine(*sides)
    return _outer(u, v) + _outer(c[None] * u2 + s[None] * u3, v2) + _outer(c[None] * u3 - s[None] * u2, v3)


def _residuals(points: _Points, rotation, per_weight: _Lanes) -> tuple[_Vectors, _Vectors]:
    """Weighted means of the residuals without translation, and of their squares."""
    model, data = _centred(points)
    residual = data - rotate_lanes(rotation, model)
    share = (points.weights * per_weight[None])[:, None]
    return total(share * residual), total(share * residual * residual)


def _dominant_pair(covariance: Float[Array, "3 3 lanes"]) -> tuple[_Vectors, _Vectors, _Vectors]:
    """The left and right singular vectors of the largest singular value, and all three values, unsorted."""
    scale = jnp.abs(covariance).max((0, 1))
    first, second, third, gram = _orthogonal_columns(covariance / jnp.where(scale > 0, scale, 1)[None, None])
    lengths = jnp.sqrt(gram[:3])
    chosen = jnp.argmax(gram[:3], axis=0)[None]  # compared as they left the loop: see there on ties
    column = jnp.where(chosen == 0, first, jnp.where(chosen == 1, second, third))
    length = lengths.max(0)[None]
    v = column[3:]
    return jnp.where(length > 0, column[:3] / jnp.where(length > 0, length, 1), v), v, lengths * scale[None]


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
    return jnp.stack([_dot(a, b) for a, b in pairs])


def _turn(gram: Float[Array, "4 lanes"]) -> tuple[_Lanes, _Lanes]:
    """Cosine and sine of the smaller of the two turns that make the first two columns orthogonal."""
    difference, product = gram[1] - gram[0], 2 * gram[3]
    # tan of the angle, from the smaller root of t^2 + 2 zeta t - 1 = 0 with zeta = difference / product
    size = jnp.abs(difference) + jnp.sqrt(difference**2 + product**2)
    t = jnp.where(gram[1] >= gram[0], product, -product) / jnp.where(size > 0, size, 1)
    c = jax.lax.rsqrt(1 + t * t)
    return c, c * t


def _perpendiculars(unit: _Vectors) -> tuple[_Vectors, _Vectors]:
    """Two unit vectors that make a right-handed frame with `unit`, by a formula that rounding cannot tip over.

    With the sign of z in the divisor, this is at least 1 in size (Duff et al., JCGT 6(1), 2017).
    """
    x, y, z = unit
    sign = jnp.where(z < 0, -1, 1).astype(unit.dtype)
    a = -1 / (sign + z)
    b = x * y * a
    return jnp.stack([1 + sign * x * x * a, sign * b, -sign * x]), jnp.stack([b, sign + y * y * a, -y])


def _cosine_and_sine(adjacent: _Lanes, opposite: _Lanes) -> tuple[_Lanes, _Lanes]:
    """Of the angle between two sides of a right triangle; of no turn where both vanish."""
    size = jnp.maximum(jnp.abs(adjacent), jnp.abs(opposite))
    adjacent, opposite = (x / jnp.where(size > 0, size, 1) for x in (adjacent, opposite))
    length = jnp.where(size > 0, jnp.sqrt(adjacent**2 + opposite**2), 1)
    return jnp.where(size > 0, adjacent / length, 1), opposite / length


def _dot(a: _Vectors, b: _Vectors) -> _Lanes:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _outer(a: _Vectors, b: _Vectors) -> Float[Array, "3 3 lanes"]:
    return a[:, None] * b[None]
