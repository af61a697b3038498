"""Why labels are doubtful, a short sentence each, besides what the labelling itself doubts."""

from collections.abc import Mapping
from typing import Any

from dshpm_jax._control.tuning import TUNING
from dshpm_jax._labelling import Labelling
from dshpm_jax._size import size_doubt


def doubts_of(labelling: Labelling, completeness: float) -> list[str]:
    """What only the recording shows, or the labelling has said itself in `stats["doubts"]`."""
    poor = completeness < 0.5 or _fits_badly(labelling.stats.get("model_fit"))
    size = size_doubt(labelling.recording, labelling.model) if poor else ""
    return [*([size] if size else []), *labelling.stats.get("doubts", ())]


def all_doubts(figures: Mapping[str, Any]) -> tuple[str, ...]:
    """Those of `figures`, and what their numbers tell."""
    fit, doubts = figures.get("model_fit"), tuple(figures.get("doubts", ()))
    if not _fits_badly(fit):
        return doubts
    if figures["labelled_points"]:
        return (*doubts, f"its labels hold only {fit:.0%} of the usual evidence")
    return doubts or ("none of its points fits the model",)  # which a doubt explains, if there is any


def _fits_badly(fit: float | None) -> bool:
    return fit is not None and fit < TUNING.poor_fit_below
