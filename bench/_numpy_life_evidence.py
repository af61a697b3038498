"""Evidence for labels as one would write it in numpy: float64, stacks of fits by `np.linalg.svd`, frame by frame."""

import math

import numpy as np

from dshpm_jax._kernels import life_evidence as kernel
from dshpm_jax._kernels.rigid_fit import MIN_SPREAD
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
    shape, own, softness = asked.shape[marker], asked.own[marker], asked.softness[marker]
    base = np.where(there, 1 / softness**2, 0.0)
    predicted, weight, posed = _predict(places, there, shape, own, softness, base)
    deviation = np.where(posed, _deviation(shape, own, base, weight, asked.spread[marker]), np.inf)
    seen = np.isfinite(points).all(-1)
    points = np.where(seen[:, None], points, 0.0)
    square = ((points - predicted[:, None]) ** 2).sum(-1)
    axis = np.where(posed, deviation / math.sqrt(3), 1.0)[:, None]
    by_pose = np.where(posed[:, None], _log_t(square, axis, 3), kernel.WORST)
    by_distance = _by_distance(points, places, there, shape, own, softness)
    second = there & (there.cumsum(1) == 2)
    vague = deviation > kernel.VAGUE * (second * softness).sum(1)
    found = np.where((posed & ~vague)[:, None], by_pose, np.maximum(by_distance, by_pose))
    known = (there.sum(1) >= kernel.MIN_DISTANCES)[:, None]
    return np.where(seen & known, np.maximum(found, kernel.WORST), np.where(seen, kernel.UNKNOWN, kernel.WORST))


def _predict(places, there, shape, own, softness, base):
    """Places of the markers, the weights of their neighbours in the last fit, and which have a pose."""
    weight = base
    for _ in range(kernel.ROBUST_ROUNDS):
        turn, model_mean, data_mean, _ = _fit(shape, places, weight)
        off = (shape - model_mean[:, None]) @ np.swapaxes(turn, 1, 2) + data_mean[:, None] - places
        weight = base / (1 + (off**2).sum(-1) / (kernel.ROBUST_SCALE * softness) ** 2) ** 2
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


def _deviation(shape, own, base, weight, spread):
    share = weight / np.maximum(weight.sum(1), 1e-12)[:, None]
    middle = (share[..., None] * shape).sum(1)
    extent = (share * ((shape - middle[:, None]) ** 2).sum(-1)).sum(1)
    leverage = ((own - middle) ** 2).sum(-1) / np.maximum(extent, 1.0)
    softness = np.sqrt(1 / np.maximum(base.mean(1), 1e-12))
    lost = 1 - weight.sum(1) / np.maximum(base.sum(1), 1e-12)
    few = 1 / np.maximum((share > 0.02).sum(1), 1)
    return np.sqrt(spread**2 + softness**2 * few * (0.5 + leverage) * 0.5 + (lost * spread) ** 2)


def _by_distance(points, places, there, shape, own, softness):
    expected = np.linalg.norm(shape - own[:, None], axis=-1)
    near = there & (there.cumsum(1) <= kernel.MAX_DISTANCES)
    error = np.linalg.norm(points[None, :, None] - places[:, None], axis=-1) - expected[:, None]
    terms = np.where(near[:, None], _log_t(error**2, np.where(near, softness, 1.0)[:, None], 1), 0.0)
    return terms.sum(-1) - kernel.MIRROR


def _log_t(square, deviation, dimensions: int):
    """Logarithm of a t density over the background, for squared distances (mm^2)."""
    tail = kernel.TAIL
    peak = math.lgamma((tail + dimensions) / 2) - math.lgamma(tail / 2) - 0.5 * dimensions * math.log(tail * math.pi)
    fall = 0.5 * (tail + dimensions) * np.log1p(square / (tail * deviation**2))
    return peak + dimensions * (kernel.BACKGROUND - np.log(deviation)) - fall
