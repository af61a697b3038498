"""Points and frames in plain numpy: what is seen, runs and samples of frames, distances, and the rigid fit.

Lengths are millimetres.
"""

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._types import MIN_FIT_POINTS

MIN_LINE_COVARIANCE = 1.0
"""mm^2; used in `rigid_fit`: if the second singular value of the covariance < this, the points lie in a line and leave
the turn about it open, so there is no pose; by hand."""


def is_seen(points: Float[np.ndarray, "*frames points 3"]) -> Bool[np.ndarray, "*frames points"]:
    """Where there is a point: no coordinate is missing (many times faster than to ask for `all` of three)."""
    finite = np.isfinite(points)
    return finite[..., 0] & finite[..., 1] & finite[..., 2]


def runs(where: Bool[np.ndarray, " frames"]) -> list[tuple[int, int]]:
    """Half-open ranges of the frames in which something holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist()))


def evenly_spaced(count: int, most: int, rounded: bool = False) -> Int[np.ndarray, " picked"]:
    """At most `most` of the numbers 0 to `count - 1`, the first and the last among them; all, where they are no more.

    Ascending, each once, as evenly as whole numbers can be: each is the next below its even place, or, if `rounded`,
    the nearest.
    """
    places = np.linspace(0, count - 1, min(count, most))
    return (places.round() if rounded else places).astype(int)


def evenly_inside(count: int, most: int) -> Int[np.ndarray, " picked"]:
    """The numbers from 0 to `count - 1` nearest to `most` even places, the outer of which are a step inside the ends.

    Ascending, each once.
    """
    return np.unique(np.linspace(0, count - 1, most + 2)[1:-1].round().astype(int)) if count else np.zeros(0, int)


def every_nth(count: int, most: int) -> slice:
    """Picks at most `most` of `count` things from the first on, all with the same whole step between them."""
    return slice(None, None, max(1, -(-count // most)))


def pair_distances(points: Float[np.ndarray, "*frames points 3"]) -> Float[np.ndarray, "*frames points points"]:
    """Distances between all points, from difference vectors."""
    return np.linalg.norm(points[..., :, None, :] - points[..., None, :, :], axis=-1)


def rigid_fit(
    shape: Float[np.ndarray, "markers 3"], points: Float[np.ndarray, "frames markers 3"]
) -> tuple[Float[np.ndarray, "frames 3 3"], Float[np.ndarray, "frames 3"]]:
    """Rotation and translation of a shape onto the seen points of each frame; NaN with fewer than 3 or in a line.

    Minimises the sum of squares of `rotation @ shape + translation - points`, never a reflection. Markers whose place
    in the shape is NaN take no part.
    """
    seen = is_seen(points) & is_seen(shape)
    count = np.maximum(seen.sum(1), 1)[:, None]
    model = np.where(seen[..., None], np.nan_to_num(shape), 0)
    data = np.where(seen[..., None], points, 0)
    model_mean, data_mean = model.sum(1) / count, data.sum(1) / count
    model = np.where(seen[..., None], model - model_mean[:, None], 0)
    data = np.where(seen[..., None], data - data_mean[:, None], 0)
    rotation, size = _best_rotations(np.einsum("fmi,fmj->fij", data, model))
    translation = data_mean - np.einsum("fij,fj->fi", rotation, model_mean)
    poor = (seen.sum(1) < MIN_FIT_POINTS) | (size[:, 1] < MIN_LINE_COVARIANCE)
    rotation[poor], translation[poor] = np.nan, np.nan
    return rotation, translation


def weighted_rigid_fit(
    shape: Float[np.ndarray, "markers 3"],
    points: Float[np.ndarray, "frames markers 3"],
    weight: Float[np.ndarray, "*frames markers"],
) -> tuple[Float[np.ndarray, "frames 3 3"], Float[np.ndarray, "frames 3"], Float[np.ndarray, "frames"]]:
    """Weighted rigid fit of a whole shape to the points seen, never a reflection.

    Returns rotation, translation (mm), and how far the matched points spread across their longest direction (RMS, mm):
    0 for points in a line, around which the rotation is arbitrary.
    """
    seen = is_seen(points)
    points = np.where(seen[..., None], points, 0.0)
    share = np.where(seen, weight, 0.0)
    share = share / np.maximum(share.sum(1, keepdims=True), np.finfo(float).tiny)
    model_mean, data_mean = share @ shape, np.einsum("fm,fmi->fi", share, points)
    model, data = shape - model_mean[:, None], points - data_mean[:, None]
    rotation, size = _best_rotations(np.einsum("fm,fmi,fmj->fij", share, data, model))
    return rotation, data_mean - np.einsum("fij,fj->fi", rotation, model_mean), np.sqrt(size[:, 1])


def predict_last(
    shape: Float[np.ndarray, "neighbours+1 3"], points: Float[np.ndarray, "frames neighbours 3"], weight: np.ndarray
) -> Float[np.ndarray, "frames 3"]:
    """Where the last place of a shape is when the others are fitted to the points seen, three or more of them (mm)."""
    rotation, translation, _ = weighted_rigid_fit(shape[:-1], points, weight)
    return np.einsum("fij,j->fi", rotation, shape[-1]) + translation


def _best_rotations(
    covariance: Float[np.ndarray, "frames 3 3"],
) -> tuple[Float[np.ndarray, "frames 3 3"], Float[np.ndarray, "frames 3"]]:
    """The rotations that take a model best to data, never reflections, and the singular values of their covariance."""
    u, size, vt = np.linalg.svd(covariance)
    flip = np.ones((len(covariance), 3))
    flip[:, 2] = np.sign(np.linalg.det(u @ vt))
    return np.einsum("fij,fj,fjk->fik", u, flip, vt), size
