"""Several subjects in one recording: their models side by side make one."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from dshpm_jax._model import Segment, SubjectModel
from dshpm_jax._types import NO_PARENT


def side_by_side(models: Mapping[str, SubjectModel]) -> SubjectModel:
    """What `combine_models` makes of models and the names of their subjects."""
    if not models:
        raise ValueError("no model was given; give one for each subject")
    if wrong := next((name for name in models if not name or ":" in name), None):
        raise ValueError(f"a subject is called '{wrong}'; give each a name without a colon")
    each = list(models.values())
    first = np.cumsum([0, *(model.num_markers for model in each)]).tolist()
    first_segment = np.cumsum([0, *(len(model.segments) for model in each)]).tolist()
    return SubjectModel(
        markers=tuple(f"{name}:{marker}" for name, model in models.items() for marker in model.markers),
        segments=tuple(
            _moved(segment, name, marker, parent)
            for (name, model), marker, parent in zip(models.items(), first, first_segment)
            for segment in model.segments
        ),
        pair_mean=_apart([model.pair_mean for model in each]),
        pair_spread=_apart([model.pair_spread for model in each]),
        neighbourhoods=tuple(
            replace(near, markers=tuple(m + marker for m in near.markers))
            for model, marker in zip(each, first)
            for near in model.neighbourhoods
        ),
        sources=tuple(source for model in each for source in model.sources),
    )


def subjects_of(model: SubjectModel) -> list[str]:
    """Names of the subjects of a combined model, in order; one without a name in any other."""
    return list(dict.fromkeys(marker.rpartition(":")[0] for marker in model.markers))


def _moved(segment: Segment, subject: str, markers: int, segments: int) -> Segment:
    """A segment of a model whose markers and segments come after so many others."""
    return replace(
        segment,
        name=f"{subject}:{segment.name}",
        markers=tuple(m + markers for m in segment.markers),
        parent=NO_PARENT if segment.parent == NO_PARENT else segment.parent + segments,
        join=tuple(m + markers for m in segment.join),
    )


def _apart(tables: Sequence[np.ndarray]) -> np.ndarray:
    """Tables of pairs as one, with NaN for pairs of two subjects."""
    ends = np.cumsum([len(table) for table in tables])
    whole = np.full((ends[-1], ends[-1]), np.nan)
    for end, table in zip(ends, tables):
        whole[end - len(table) : end, end - len(table) : end] = table
    return whole
