"""Neighbourhoods: for every marker the markers that predict its place best, and how well they do."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import every_nth, is_seen, predict_last
from dshpm_jax._model import MAX_NEIGHBOURS, Neighbourhood
from dshpm_jax._model_building.expectation import expected_spread, general_spread
from dshpm_jax._model_building.shapes import mean_shape, with_distances
from dshpm_jax._model_building.statistics import DistanceStatistics
from dshpm_jax._model_building.tuning import TUNING, ModelTuning
from dshpm_jax._types import MIN_FIT_POINTS


def build_neighbourhoods(
    names: Sequence[str],
    clips: Sequence[Float[np.ndarray, "frames markers 3"]],
    statistics: DistanceStatistics,
    loose: bool = False,
    tuning: ModelTuning = TUNING,
) -> tuple[Neighbourhood, ...]:
    """A neighbourhood for every marker, made from what the clips show and from what bodies do in general.

    Arguments:
        loose: whether joints turn so far in the clips that mean shapes shrink (see `with_distances`).
    """
    clips = [clip[every_nth(len(clip), tuning.max_frames)] for clip in clips]
    spread = expected_spread(statistics, names, tuning)
    distance_sd = np.sqrt(spread**2 + (tuning.general_one_part * statistics.mean) ** 2 + tuning.general_mm**2)
    distance_sd = np.where(np.isfinite(distance_sd), distance_sd, np.inf)
    np.fill_diagonal(distance_sd, np.inf)
    general = general_spread(statistics, names, tuning)
    return tuple(_neighbourhood(clips, statistics, distance_sd, general, m, loose, tuning) for m in range(len(names)))


def _neighbourhood(
    clips: Sequence[np.ndarray],
    statistics: DistanceStatistics,
    distance_sd: np.ndarray,
    general: np.ndarray,
    marker: int,
    loose: bool,
    tuning: ModelTuning,
) -> Neighbourhood:
    order = np.argsort(distance_sd[marker], kind="stable")[:MAX_NEIGHBOURS]
    order = order[np.isfinite(distance_sd[marker, order])]
    ids = np.append(order, marker)
    shape = mean_shape(np.concatenate([clip[:, ids] for clip in clips]), statistics.mean[np.ix_(ids, ids)], tuning)
    if loose:
        shape = with_distances(shape, statistics.mean[np.ix_(ids, ids)], distance_sd[np.ix_(ids, ids)], tuning)
    sd = distance_sd[marker, order]
    seen = [prediction_error(clip[:, ids], shape, 1 / sd**2, tuning) for clip in clips]
    # The liveliest recording counts: a static predicts every marker perfectly and says nothing.
    learnt = max((error for error in seen if np.isfinite(error)), default=0.0)
    seconds = float(np.median(statistics.seconds[marker, order])) if len(order) else 0.0
    usual = np.sqrt(1 / np.mean(1 / general[marker, order] ** 2)) if len(order) else tuning.min_marker_sd_mm
    variance = (seconds * learnt**2 + tuning.general_seconds * usual**2) / (seconds + tuning.general_seconds)
    return Neighbourhood(
        tuple(int(i) for i in order), shape, sd, float(np.hypot(tuning.min_marker_sd_mm, np.sqrt(variance)))
    )


def prediction_error(points: np.ndarray, shape: np.ndarray, weight: np.ndarray, tuning: ModelTuning) -> float:
    """RMS error of the prediction of the last marker from those of the others that are seen, in mm.

    NaN where fewer than 3 ever are; the worst frames are left out, for hand labels are wrong in a few.
    """
    seen = is_seen(points)
    frames = points[seen[:, -1] & (seen[:, :-1].sum(1) >= MIN_FIT_POINTS)]
    if not len(frames):
        return np.nan
    error = np.linalg.norm(predict_last(shape, frames[:, :-1], weight) - frames[:, -1], axis=1)
    error = np.sort(error)[: max(1, int(tuning.kept_error_share * len(error)))]
    return float(np.sqrt((error**2).mean()))
