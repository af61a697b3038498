"""Evidence for labels as one would write it in numpy: float64, stacks of fits by `np.linalg.svd`, frame by frame."""

import math

import numpy as np

from dshpm_jax._kernels.rigid_fit import MIN_SPREAD
from dshpm_jax._null_model import NullModel
from dshpm_jax._requests import LifeEvidence
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH


def evidence(asked: LifeEvidence) -> np.ndarray:
    """What the kernel answers to a request: (lanes, slots), in nats."""
    found = np.empty((len(asked.frame), asked.points.shape[1]))
    for frame in np.unique(asked.frame):
        lanes = np.flatnonzero(asked.frame == frame)
        found[lanes] = _of_frame(asked, asked.points[frame], asked.identified[frame], asked.marker[lanes])
    return found


def _of_frame(asked: LifeEvidence, points, identified, marker) -> np.ndarray:
    around = asked.neighbours[marker]
    places = identified[np.maximum(around, 0)]
    there = (around != NO_MATCH) & np.isfinite(places).all(-1)
    places = np.where(there[..., None], places, 0.0)
    null = asked.null
    shape, own, distance_sd = asked.shape[marker], asked.own[marker], asked.distance_sd[marker]
    base = np.where(there, 1 / distance_sd**2, 0.0)
    predicted, weight, posed = _predict(null, places, there, shape, own, distance_sd, base)
    deviation = np.where(posed, _deviation(null, shape, own, base, weight, asked.marker_sd[marker]), np.inf)
    seen = np.isfinite(points).all(-1)
    points = np.where(seen[:, None], points, 0.0)
    square = ((points - predicted[:, None]) ** 2).sum(-1)
    axis = np.where(posed, deviation / math.sqrt(3), 1.0)[:, None]
    by_pose = np.where(posed[:, None], _log_t(null, square, axis, 3), null.min_llr)
    by_distance = _by_distance(null, points, places, there, shape, own, distance_sd)
    second = there & (there.cumsum(1) == 2)
    vague = deviation > null.max_pose_sd_ratio * (second * distance_sd).sum(1)
    found = np.where((posed & ~vague)[:, None], by_pose, np.maximum(by_distance, by_pose))
    known = (there.sum(1) >= null.min_distances)[:, None]
    return np.where(seen & known, np.maximum(found, null.min_llr), np.where(seen, null.unknown_llr, null.min_llr))


def _predict(null, places, there, shape, own, distance_sd, base):
    """Places of the markers, the weights of their neighbours in the last fit, and which have a pose."""
    weight = base
    for _ in range(null.robust_rounds):
        turn, model_mean, data_mean, _ = _fit(shape, places, weight)
        off = (shape - model_mean[:, None]) @ np.swapaxes(turn, 1, 2) + data_mean[:, None] - places
        weight = base / (1 + (off**2).sum(-1) / (null.robust_scale * distance_sd) ** 2) ** 2
    turn, model_mean, data_mean, second = _fit(shape, places, weight)
    place = (turn @ (own - model_mean)[..., None])[..., 0] + data_mean
    return place, weight, (second >= MIN_SPREAD**2) & (there.sum(1) >= MIN_FIT_POINTS)


def _fit(shape, places, weight):
    """Rotations, the means about which they turn, and second singular values."""
    share = (weight / np.maximum(weight.sum(1, keepdims=True), 1e-12))[..., None]
    model_mean, data_mean = (share * shape).sum(1), (share * places).sum(1)
    centred = share * (places - data_mean[:, None])
    u, s, vt = np.linalg.svd(np.swapaxes(centred, 1, 2) @ (shape - model_mean[:, None]))
    u[:, :, 2] *= np.sign(np.linalg.det(u @ vt))[:, None]
    return u @ vt, model_mean, data_mean, s[:, 1]


def _deviation(null, shape, own, base, weight, marker_sd):
    share = weight / np.maximum(weight.sum(1), 1e-12)[:, None]
    middle = (share[..., None] * shape).sum(1)
    extent = (share * ((shape - middle[:, None]) ** 2).sum(-1)).sum(1)
    leverage = ((own - middle) ** 2).sum(-1) / np.maximum(extent, 1.0)
    typical_sd = np.sqrt(1 / np.maximum(base.mean(1), 1e-12))
    lost = 1 - weight.sum(1) / np.maximum(base.sum(1), 1e-12)
    few = 1 / np.maximum((share > null.min_weight_share).sum(1), 1)
    variance = typical_sd**2 * few * (null.leverage_offset + leverage) * null.few_neighbours_variance
    return np.sqrt(marker_sd**2 + variance + (lost * marker_sd) ** 2)


def _by_distance(null, points, places, there, shape, own, distance_sd):
    expected = np.linalg.norm(shape - own[:, None], axis=-1)
    near = there & (there.cumsum(1) <= null.max_distances)
    error = np.linalg.norm(points[None, :, None] - places[:, None], axis=-1) - expected[:, None]
    terms = np.where(near[:, None], _log_t(null, error**2, np.where(near, distance_sd, 1.0)[:, None], 1), 0.0)
    return terms.sum(-1) - null.reflection_penalty


def _log_t(null: NullModel, square, deviation, dimensions: int):
    """Logarithm of a t density over the background, for squared distances (mm^2)."""
    tail = null.t_dof
    peak = math.lgamma((tail + dimensions) / 2) - math.lgamma(tail / 2) - 0.5 * dimensions * math.log(tail * math.pi)
    fall = 0.5 * (tail + dimensions) * np.log1p(square / (tail * deviation**2))
    return peak + dimensions * (math.log(null.background_mm) - np.log(deviation)) - fall
