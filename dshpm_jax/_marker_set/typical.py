"""The typical body of a marker set: segments and neighbourhoods, whose spreads are those of one subject who moves.

Clips of several people make no ordinary model: what their builds differ in would look like motion.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import every_nth, is_seen
from dshpm_jax._model import Neighbourhood, SubjectModel
from dshpm_jax._model_building.expectation import expected_spread
from dshpm_jax._model_building.neighbours import build_neighbourhoods, prediction_error
from dshpm_jax._model_building.segments import build_segments
from dshpm_jax._model_building.shapes import mean_shape
from dshpm_jax._model_building.statistics import DistanceStatistics
from dshpm_jax._model_building.tuning import TUNING, ModelTuning

_Clips = Sequence[Float[np.ndarray, "frames markers 3"]]


def typical_model(
    markers: tuple[str, ...],
    sized: Sequence[_Clips],
    each: Sequence[DistanceStatistics],
    statistics: DistanceStatistics,
    sources: tuple[str, ...],
    tuning: ModelTuning = TUNING,
) -> SubjectModel:
    """The typical body.

    Arguments:
        sized: the clips of each subject, brought to one size (mm).
        each: the pair statistics of each subject, in their own size.
        statistics: mean distances of the set, how they vary within a subject, and what was seen of them by all.
        sources: names of the subjects.
    """
    clips = [clip for own in sized for clip in own]
    wide = build_neighbourhoods(markers, clips, statistics, tuning=tuning)
    near = tuple(_of_one_body(found, marker, sized, each, tuning) for marker, found in enumerate(wide))
    return SubjectModel(
        markers=markers,
        segments=build_segments(markers, clips, statistics, tuning=tuning),
        pair_mean=statistics.mean,
        pair_spread=expected_spread(statistics, markers, tuning),
        neighbourhoods=near,
        sources=sources,
    )


def _of_one_body(
    near: Neighbourhood, marker: int, sized: Sequence[_Clips], each: Sequence[DistanceStatistics], tuning: ModelTuning
) -> Neighbourhood:
    """The neighbourhood with the prediction error that it has in one subject, whose shape is their own."""
    ids = [*near.markers, marker]
    errors = []
    for clips, statistics in zip(sized, each, strict=True):
        few = [clip[every_nth(len(clip), tuning.max_frames)][:, ids] for clip in clips]
        if not np.all(is_seen(np.concatenate(few)).any(0)):
            continue
        shape = mean_shape(np.concatenate(few), statistics.mean[np.ix_(ids, ids)], tuning)
        found = [prediction_error(clip, shape, 1 / near.distance_sd**2, tuning) for clip in few]
        if known := [error for error in found if np.isfinite(error)]:
            errors.append(max(known))
    if not errors:
        return near
    least = float(np.hypot(tuning.min_marker_sd_mm, np.median(errors)))
    return Neighbourhood(near.markers, near.shape, near.distance_sd, min(near.marker_sd, least))
