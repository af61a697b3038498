"""Mean shapes of segments, and the centres of the joints between them."""

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import evenly_spaced, is_seen, pair_distances, rigid_fit
from dshpm_jax._model_building.tuning import TUNING, ModelTuning
from dshpm_jax._types import MIN_FIT_POINTS


def mean_shape(
    points: Float[np.ndarray, "frames markers 3"],
    distances: Float[np.ndarray, "markers markers"],
    tuning: ModelTuning = TUNING,
) -> Float[np.ndarray, "markers 3"]:
    """Mean places of a segment's markers in a frame of its own, centred (mm), by generalised Procrustes analysis.

    Frames with at least 3 of the markers take part, so markers that are never all seen together are still placed
    through those that they are seen with. What no frame can place comes from the mean pair distances alone.
    """
    markers = points.shape[1]
    if markers < MIN_FIT_POINTS:
        return _from_distances(distances)
    seen = is_seen(points)
    frames = np.flatnonzero(seen.sum(1) >= MIN_FIT_POINTS)
    if not len(frames):
        return _from_distances(distances)
    points = points[frames[evenly_spaced(len(frames), tuning.shape_frames)]]
    shape = points[int(np.argmax(is_seen(points).sum(1)))].copy()
    for _ in range(tuning.shape_rounds):
        rotation, translation = rigid_fit(shape, points)
        here = np.einsum("fji,fmj->fmi", rotation, points - translation[:, None])
        seen = is_seen(here)
        found = seen.any(0)
        if not found.any():  # all markers in a line have no pose
            return _from_distances(distances)
        # The median bears the few frames in which a hand label is wrong.
        shape[found] = np.stack([np.median(here[seen[:, m], m], axis=0) for m in np.flatnonzero(found)])
    if not np.isfinite(shape).all():
        return _from_distances(distances)
    return shape - shape.mean(0)


def _from_distances(distances: Float[np.ndarray, "markers markers"]) -> Float[np.ndarray, "markers 3"]:
    """Places with these distances by classical scaling, centred; the handedness is arbitrary, so a last resort.

    A distance that nobody saw is taken as the way over other markers.
    """
    count = len(distances)
    whole = np.where(np.isfinite(distances), distances, np.inf)
    for k in range(count):
        whole = np.minimum(whole, whole[:, k : k + 1] + whole[k])
    whole = np.where(np.isfinite(whole), whole, 0)
    centre = np.eye(count) - 1 / count
    values, vectors = np.linalg.eigh(-0.5 * centre @ whole**2 @ centre)
    places = np.zeros((count, 3))
    best = np.argsort(values)[::-1][:3]
    places[:, : len(best)] = vectors[:, best] * np.sqrt(np.maximum(values[best], 0))
    return places


def with_distances(
    shape: Float[np.ndarray, "markers 3"],
    distances: Float[np.ndarray, "markers markers"],
    distance_sd: Float[np.ndarray, "markers markers"],
    tuning: ModelTuning = TUNING,
) -> Float[np.ndarray, "markers 3"]:
    """A shape near `shape` that keeps the mean distances, the most rigid first (all mm).

    The mean place of a marker that turns about another lies between the two, so a mean shape of loose markers is
    smaller than any that was ever seen. Least squares of the distances, weighted by 1 / distance_sd^2, by majorisation.
    """
    weight = np.where(np.isfinite(distances), 1 / distance_sd**2, 0)
    np.fill_diagonal(weight, 0)
    wanted = np.nan_to_num(distances)
    pull = np.linalg.pinv(np.diag(weight.sum(1)) - weight)
    for _ in range(tuning.distance_rounds):
        now = pair_distances(shape)
        ratio = weight * wanted / np.where(now > 0, now, np.inf)
        shape = pull @ (np.diag(ratio.sum(1)) - ratio) @ shape
    return shape


def joint_centre(
    parent_poses: tuple[np.ndarray, np.ndarray],
    segment_poses: tuple[np.ndarray, np.ndarray],
    parent_guess: Float[np.ndarray, "3"],
    segment_guess: Float[np.ndarray, "3"],
    tuning: ModelTuning = TUNING,
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"], float]:
    """The point that is fixed in both segments (mm, in the frames of their shapes), and its root mean square error.

    Least squares of R_p c_p + t_p = R_s c_s + t_s over the frames, drawn towards the guesses where the motion does
    not say (a hinge leaves its axis open, a still joint everything). NaN error without common frames.
    """
    (r_p, t_p), (r_s, t_s) = parent_poses, segment_poses
    both = is_seen(t_p) & is_seen(t_s)
    if not both.any():
        return parent_guess, segment_guess, np.nan
    r_p, t_p, r_s, t_s = r_p[both], t_p[both], r_s[both], t_s[both]
    weight = np.sqrt(tuning.joint_frames / len(t_p)) / tuning.joint_noise_mm
    rows = np.concatenate([r_p, -r_s], axis=-1).reshape(-1, 6) * weight
    prior = np.eye(6) / tuning.joint_prior_mm
    guess = np.concatenate([parent_guess, segment_guess])
    solution, *_ = np.linalg.lstsq(
        np.concatenate([rows, prior]), np.concatenate([(t_s - t_p).ravel() * weight, prior @ guess]), rcond=None
    )
    gap = r_p @ solution[:3] + t_p - r_s @ solution[3:] - t_s
    return solution[:3], solution[3:], float(np.sqrt((gap**2).sum(-1).mean()))
