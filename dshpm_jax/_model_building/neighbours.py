"""Neighbourhoods: for every marker the markers that predict its place best, and how well they do."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._model_building.shapes import mean_shape
from dshpm_jax._model_building.statistics import MAX_FRAMES, PairStatistics

MAX_NEIGHBOURS = 8
"""More neighbours average out more noise, but the eighth is already on the next limb."""

UNPROVEN_SHARE = 0.05
"""A distance that was only seen standing still may change by this share of itself when the subject moves."""

SHARE, NOISE_MM = 0.015, 2.0
"""Every distance may change by this share of itself, and by this much, between recordings."""

MIN_SPREAD_MM = 3.0
"""A short clip may predict a marker better than the next recording will."""


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """The markers nearest to rigid with one marker.

    Attributes:
        markers: identities of the neighbours, the softest last.
        shape: mean places of the neighbours and, last, of the marker itself, in a frame of their own (mm).
        softness: how much the distance of each neighbour to the marker varies (mm).
        spread: root mean square error with which the neighbours predicted the marker in the model's recordings (mm).
    """

    markers: tuple[int, ...]
    shape: Float[np.ndarray, "neighbours+1 3"]
    softness: Float[np.ndarray, " neighbours"]
    spread: float


def softness(statistics: PairStatistics) -> Float[np.ndarray, "markers markers"]:
    """How much each pair distance may vary (mm): what was seen, more where little was; infinite if never seen."""
    unproven = (1 - statistics.evidence) * UNPROVEN_SHARE * statistics.mean
    soft = np.sqrt(statistics.spread**2 + (SHARE * statistics.mean) ** 2 + NOISE_MM**2 + unproven**2)
    soft = np.where(np.isfinite(soft), soft, np.inf)
    np.fill_diagonal(soft, np.inf)
    return soft


def build_neighbourhoods(
    clips: Sequence[Float[np.ndarray, "frames markers 3"]], statistics: PairStatistics
) -> tuple[Neighbourhood, ...]:
    """A neighbourhood for every marker."""
    points = np.concatenate([clip[:: max(1, -(-len(clip) // MAX_FRAMES))] for clip in clips])
    soft = softness(statistics)
    return tuple(_neighbourhood(points, statistics.mean, soft, marker) for marker in range(points.shape[1]))


def _neighbourhood(points: np.ndarray, mean: np.ndarray, soft: np.ndarray, marker: int) -> Neighbourhood:
    order = np.argsort(soft[marker], kind="stable")[:MAX_NEIGHBOURS]
    order = order[np.isfinite(soft[marker, order])]
    ids = np.append(order, marker)
    shape = mean_shape(points[:, ids], mean[np.ix_(ids, ids)])
    return Neighbourhood(
        tuple(int(i) for i in order),
        shape,
        soft[marker, order],
        _prediction_spread(points[:, ids], shape, soft[marker, order]),
    )


def _prediction_spread(points: np.ndarray, shape: np.ndarray, soft: np.ndarray) -> float:
    """RMS error of the prediction of the last marker from the others, 1 % of the worst frames left out."""
    frames = points[np.isfinite(points).all((1, 2))]
    if len(soft) < 3 or not len(frames):
        return float(max(MIN_SPREAD_MM, soft.mean() if len(soft) else MIN_SPREAD_MM))
    rotation, translation = weighted_fit(shape[:-1], frames[:, :-1], 1 / soft**2)
    error = np.linalg.norm(np.einsum("fij,j->fi", rotation, shape[-1]) + translation - frames[:, -1], axis=1)
    error = np.sort(error)[: max(1, int(0.99 * len(error)))]
    return float(np.hypot(MIN_SPREAD_MM, np.sqrt((error**2).mean())))


def weighted_fit(
    shape: Float[np.ndarray, "markers 3"], points: Float[np.ndarray, "frames markers 3"], weight: np.ndarray
) -> tuple[Float[np.ndarray, "frames 3 3"], Float[np.ndarray, "frames 3"]]:
    """Weighted rigid fit of a shape to fully seen points, never a reflection."""
    share = weight / weight.sum()
    model_mean, data_mean = share @ shape, np.einsum("m,fmi->fi", share, points)
    covariance = np.einsum("m,fmi,mj->fij", share, points - data_mean[:, None], shape - model_mean)
    u, _, vt = np.linalg.svd(covariance)
    flip = np.ones((len(points), 3))
    flip[:, 2] = np.sign(np.linalg.det(u @ vt))
    rotation = np.einsum("fij,fj,fjk->fik", u, flip, vt)
    return rotation, data_mean - rotation @ model_mean


def as_arrays(
    neighbourhoods: Sequence[Neighbourhood],
) -> tuple[Int[np.ndarray, "markers neighbours"], ...]:
    """Neighbours (`-1` beyond the last), their places, the markers' own places, softness and spreads, padded."""
    count = len(neighbourhoods)
    ids = np.full((count, MAX_NEIGHBOURS), -1, np.int32)
    shape = np.zeros((count, MAX_NEIGHBOURS, 3), np.float32)
    own = np.zeros((count, 3), np.float32)
    soft = np.ones((count, MAX_NEIGHBOURS), np.float32)
    spread = np.ones(count, np.float32)
    for m, found in enumerate(neighbourhoods):
        size = len(found.markers)
        ids[m, :size], shape[m, :size], own[m] = found.markers, found.shape[:-1], found.shape[-1]
        soft[m, :size], spread[m] = found.softness, found.spread
    return ids, shape, own, soft, spread
