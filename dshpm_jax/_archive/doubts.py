"""Why labels are doubtful, a short sentence each, besides what the labelling itself doubts."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from dshpm_jax._control.tuning import TUNING
from dshpm_jax._geometry import every_nth, is_seen, pair_distances
from dshpm_jax._labelling import Labelling
from dshpm_jax._recording import MILLIMETRES

SIZES = {**MILLIMETRES, "in": 25.4}  # in millimetres
SAMPLED_FRAMES = 20
FACTOR = 2.0  # between sizes that may be the same: points are more than markers, and not all markers are seen


def doubts_of(labelling: Labelling, completeness: float) -> list[str]:
    """What only the recording shows, or the labelling has said itself in `stats["doubts"]`."""
    unit = unit_doubt(labelling) if completeness < 0.5 or _fits_badly(labelling.stats.get("model_fit")) else ""
    return [*([unit] if unit else []), *labelling.stats.get("doubts", ())]


def all_doubts(figures: Mapping[str, Any]) -> tuple[str, ...]:
    """Those of `figures`, and what their numbers tell."""
    fit, doubts = figures.get("model_fit"), tuple(figures.get("doubts", ()))
    if not _fits_badly(fit):
        return doubts
    if figures["labelled_points"]:
        return (*doubts, f"its labels hold only {fit:.0%} of the usual evidence")
    return doubts or ("none of its points fits the model",)  # which a doubt explains, if there is any


def unit_doubt(labelling: Labelling) -> str:
    """Says so where the points would have the size of the model if the file's unit of length were another."""
    recording, model = labelling.recording, labelling.model
    points = _distance(recording.points)
    pairs = model.pair_mean[model.pair_mean > 0]
    if not points or not len(pairs):
        return ""
    markers = float(np.median(pairs))
    if 1 / FACTOR <= points / markers <= FACTOR:
        return ""
    size = SIZES[recording.unit] * markers / points
    unit = min(SIZES, key=lambda name: abs(np.log(SIZES[name] / size)))
    if unit == recording.unit or not 1 / FACTOR <= SIZES[unit] / size <= FACTOR:
        return ""
    return (
        f"its points lie {points:.3g} mm apart and the model's markers {markers:.3g} mm, so its unit is probably "
        f"{unit} and not {recording.unit}"
    )


def _distance(points: np.ndarray) -> float:
    """The median distance of two points seen together (mm), in frames spread over the recording; 0 where none are."""
    seen = is_seen(points)
    several = np.flatnonzero(seen.sum(1) > 1)
    some = several[every_nth(len(several), SAMPLED_FRAMES)]
    apart = [pair_distances(points[t, seen[t]])[np.triu_indices(seen[t].sum(), 1)] for t in some]
    return float(np.median(np.concatenate(apart))) if apart else 0.0


def _fits_badly(fit: float | None) -> bool:
    return fit is not None and fit < TUNING.poor_fit_below
