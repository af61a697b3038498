"""Models from labelled recordings and from subject files, put together."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from dshpm_jax._model import SubjectModel
from dshpm_jax._model_building.expectation import expected_spread
from dshpm_jax._model_building.gather import gather
from dshpm_jax._model_building.neighbours import build_neighbourhoods
from dshpm_jax._model_building.segments import build_segments
from dshpm_jax._model_building.skeleton import Skeleton, bone_groups, posed_clip
from dshpm_jax._model_building.statistics import pair_statistics
from dshpm_jax._model_building.tuning import TUNING, ModelTuning
from dshpm_jax._recording import Recording


def model_from_recordings(
    recordings: Sequence[Recording],
    segments: Mapping[str, Any] | None = None,
    template: str | None = None,
    tuning: ModelTuning = TUNING,
) -> SubjectModel:
    """What `SubjectModel.from_recordings` returns."""
    names, clips = gather(recordings)
    sources = tuple(recording.source.name for recording in recordings if recording.source)
    rates = [recording.rate for recording in recordings]
    return _from_clips(names, clips, rates, sources, tuning, segments=segments, template=template)


def model_from_skeleton(skeleton: Skeleton, source: str = "", tuning: ModelTuning = TUNING) -> SubjectModel:
    """What `SubjectModel.from_skeleton` returns."""
    clip = posed_clip(skeleton, tuning)
    names = tuple(marker.name for marker in skeleton.markers)
    rates, sources = [len(clip) / tuning.posed_seconds], (source,) if source else ()
    return _from_clips(names, [clip], rates, sources, tuning, rigid=bone_groups(skeleton))


def _from_clips(
    names: tuple[str, ...],
    clips: Sequence[Float[np.ndarray, "frames markers 3"]],
    rates: Sequence[float],
    sources: tuple[str, ...],
    tuning: ModelTuning,
    **segments: Any,
) -> SubjectModel:
    """A model from clips of the markers; `segments` are further arguments of `build_segments`."""
    statistics = pair_statistics(clips, rates, tuning)
    return SubjectModel(
        markers=names,
        segments=build_segments(names, clips, statistics, tuning=tuning, **segments),
        pair_mean=statistics.mean,
        pair_spread=expected_spread(statistics, names, tuning),
        neighbourhoods=build_neighbourhoods(names, clips, statistics, loose="rigid" in segments, tuning=tuning),
        sources=sources,
    )
