"""Whether a recording has the size of a body: a wrong unit makes it a thousand times too small or too large."""

import numpy as np

from dshpm_jax._geometry import evenly_spaced
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import MILLIMETRES, Recording

SMALLEST_MM, LARGEST_MM = 20.0, 20_000.0
"""mm; used in `size_doubt`: nothing that wears markers and moves is smaller than a finger or as large as a house; by
hand: people in metres or kilometres are taken for millimetres, and hands and robot arms for what they are."""

TIMES_THE_MODEL = 6.0
"""factor; used in `size_doubt`: a recording this many times larger or smaller than the model is in another unit; by
hand: under the factor of 10 between mm, cm and dm, above what two people in one room or half a body make."""

UNITS = {**MILLIMETRES, "in": 25.4}
"""mm; used in `size_doubt`: the units that a file may be in, whatever it says."""

UNIT_FACTOR = 2.0
"""factor; used in `size_doubt`: a unit is named if with it the sizes of recording and model differ by no more; by hand:
points are more than markers, and not all markers are seen."""

WITHOUT = 10.0
"""per cent; used in `extent`: of the points of a frame this share is left out at each end of each axis; by hand: ghosts
lie far away."""

FRAMES = 50
"""count; used in `extent`: of frames that are looked at, evenly spaced; by hand."""


SIZE_REMEDY = "points count as millimetres: say Recording(..., points_unit=...), or correct the unit in the file"


def extent(recording: Recording) -> float:
    """How large the cloud of points typically is (mm): the median over frames of its longest side, NaN if nothing is
    seen."""
    points = recording.points[evenly_spaced(recording.num_frames, FRAMES, rounded=True)]
    sides = []
    for frame in points:
        seen = frame[np.isfinite(frame).all(-1)]
        if len(seen) > 1:
            low, high = np.percentile(seen, [WITHOUT, 100 - WITHOUT], axis=0)
            sides.append((high - low).max())
    return float(np.median(sides)) if sides else np.nan


def size_doubt(recording: Recording, model: SubjectModel | None = None) -> str:
    """What a recording's size says against its unit of length, a part of a sentence; empty if nothing.

    Arguments:
        recording: points in what should be millimetres.
        model: of its subject; a recording of half as many points as it has markers should be about as large.
    """
    size = extent(recording)
    if not size > 0:
        return ""
    spread = f"its points are spread over {_length(size)}"
    known = _extent_of_model(model) if model is not None else np.nan
    many = model is not None and np.median(recording.present.sum(1)) >= model.num_markers / 2
    if many and known > 0 and not known / TIMES_THE_MODEL <= size <= known * TIMES_THE_MODEL:
        unit = _unit_that_fits(MILLIMETRES[recording.unit] * known / size)
        probably = f", so its unit is probably {unit} and not {recording.unit}" if unit else ""
        return f"{spread}, those of the model over {_length(known)}{probably}"
    if not SMALLEST_MM <= size <= LARGEST_MM:
        return f"{spread}, which is no body's size"
    return ""


def _unit_that_fits(millimetres: float) -> str:
    """The unit of about that length, or nothing."""
    unit = min(UNITS, key=lambda name: abs(np.log(UNITS[name] / millimetres)))
    return unit if 1 / UNIT_FACTOR <= UNITS[unit] / millimetres <= UNIT_FACTOR else ""


def _extent_of_model(model: SubjectModel) -> float:
    """A long distance between two markers of the model (mm), NaN if it knows none."""
    distances = model.pair_mean[np.triu_indices(model.num_markers, 1)]
    distances = distances[np.isfinite(distances)]
    return float(np.percentile(distances, 100 - WITHOUT)) if len(distances) else np.nan


def _length(millimetres: float) -> str:
    for unit, size in (("km", 1e6), ("m", 1e3)):
        if millimetres >= size:
            return f"{millimetres / size:.3g} {unit}"
    return f"{millimetres:.3g} mm"
