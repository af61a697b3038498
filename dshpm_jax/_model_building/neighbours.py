"""Neighbourhoods: for every marker the markers that predict its place best, and how well they do."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import every_nth, is_seen, predict_last
from dshpm_jax._model import MAX_NEIGHBOURS, Neighbourhood
from dshpm_jax._model_building.expectation import GENERAL_MM, GENERAL_SECONDS, expected_spread, general_share
from dshpm_jax._model_building.shapes import mean_shape, with_distances
from dshpm_jax._model_building.statistics import MAX_FRAMES, DistanceStatistics

SHARE, NOISE_MM = 0.01, 2.0
"""Every distance may change by this share of itself, and by this much, between recordings."""

MIN_SPREAD_MM = 4.0
"""A short clip may predict a marker better than the next recording will."""


def build_neighbourhoods(
    names: Sequence[str],
    clips: Sequence[Float[np.ndarray, "frames markers 3"]],
    statistics: DistanceStatistics,
    loose: bool = False,
) -> tuple[Neighbourhood, ...]:
    """A neighbourhood for every marker, made from what the clips show and from what bodies do in general.

    Arguments:
        loose: whether joints turn so far in the clips that mean shapes shrink (see `with_distances`).
    """
    clips = [clip[every_nth(len(clip), MAX_FRAMES)] for clip in clips]
    spread = expected_spread(statistics, names)
    distance_sd = np.sqrt(spread**2 + (SHARE * statistics.mean) ** 2 + NOISE_MM**2)
    distance_sd = np.where(np.isfinite(distance_sd), distance_sd, np.inf)
    np.fill_diagonal(distance_sd, np.inf)
    general = np.hypot(GENERAL_MM, general_share(names) * statistics.mean)
    return tuple(_neighbourhood(clips, statistics, distance_sd, general, m, loose) for m in range(len(names)))


def _neighbourhood(
    clips: Sequence[np.ndarray],
    statistics: DistanceStatistics,
    distance_sd: np.ndarray,
    general: np.ndarray,
    marker: int,
    loose: bool,
) -> Neighbourhood:
    order = np.argsort(distance_sd[marker], kind="stable")[:MAX_NEIGHBOURS]
    order = order[np.isfinite(distance_sd[marker, order])]
    ids = np.append(order, marker)
    shape = mean_shape(np.concatenate([clip[:, ids] for clip in clips]), statistics.mean[np.ix_(ids, ids)])
    if loose:
        shape = with_distances(shape, statistics.mean[np.ix_(ids, ids)], distance_sd[np.ix_(ids, ids)])
    sd = distance_sd[marker, order]
    seen = [_prediction_error(clip[:, ids], shape, 1 / sd**2) for clip in clips]
    # The liveliest recording counts: a static predicts every marker perfectly and says nothing.
    learnt = max((error for error in seen if np.isfinite(error)), default=0.0)
    seconds = float(np.median(statistics.seconds[marker, order])) if len(order) else 0.0
    usual = np.sqrt(1 / np.mean(1 / general[marker, order] ** 2)) if len(order) else MIN_SPREAD_MM
    variance = (seconds * learnt**2 + GENERAL_SECONDS * usual**2) / (seconds + GENERAL_SECONDS)
    return Neighbourhood(tuple(int(i) for i in order), shape, sd, float(np.hypot(MIN_SPREAD_MM, np.sqrt(variance))))


def _prediction_error(points: np.ndarray, shape: np.ndarray, weight: np.ndarray) -> float:
    """RMS error of the prediction of the last marker from those of the others that are seen, in mm.

    NaN where fewer than 3 ever are; 1 % of the worst frames are left out, for hand labels are wrong in a few.
    """
    seen = is_seen(points)
    frames = points[seen[:, -1] & (seen[:, :-1].sum(1) >= 3)]
    if not len(frames):
        return np.nan
    error = np.linalg.norm(predict_last(shape, frames[:, :-1], weight) - frames[:, -1], axis=1)
    error = np.sort(error)[: max(1, int(0.99 * len(error)))]
    return float(np.sqrt((error**2).mean()))
