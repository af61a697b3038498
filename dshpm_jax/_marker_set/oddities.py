"""Subjects of a set in whom some markers sit otherwise than in the others."""

from collections.abc import Sequence

import numpy as np

from dshpm_jax._marker_set.between import Between
from dshpm_jax._marker_set.marker_set import OddSubject, squares
from dshpm_jax._marker_set.tuning import SetTuning

NEAREST = 6
"""count; used in `odd_subjects`: a marker is judged by its distances to this many markers, the most rigid; by hand."""


def odd_subjects(
    markers: Sequence[str], subjects: Sequence[str], found: Between, tuning: SetTuning
) -> tuple[OddSubject, ...]:
    """Subjects with markers whose near-rigid distances deviate from those of all others; none of fewer than three."""
    if len(subjects) < 3:
        return ()
    count = len(markers)
    within = squares(np.nan_to_num(found.within, nan=np.inf), count, np.inf)
    near = np.argsort(within, axis=1, kind="stable")[:, : min(NEAREST, count - 1)]
    odd = []
    for k, subject in enumerate(subjects):
        off = squares(_deviation(found.rest, k), count, np.nan)
        sds = squares(_deviation(found.rest, k) / _usual(found.rest, k, tuning), count, np.nan)
        own = [m for m in range(count) if _typical(off[m, near[m]]) > tuning.odd_share]
        if names := tuple(markers[m] for m in own if _typical(sds[m, near[m]]) > tuning.odd_sds):
            odd.append(OddSubject(subject, names))
    return tuple(odd)


def _deviation(rest: np.ndarray, subject: int) -> np.ndarray:
    """How far each log distance of a subject is from the mean of the others."""
    others = np.delete(rest, subject, axis=0)
    return np.abs(rest[subject] - np.nanmean(np.where(np.isfinite(others).any(0), others, 0.0), axis=0))


def _usual(rest: np.ndarray, subject: int, tuning: SetTuning) -> np.ndarray:
    """How far the others are from their own mean, at least `least_between`."""
    others = np.delete(rest, subject, axis=0)
    others = np.where(np.isfinite(others).any(0), others, 0.0)
    return np.hypot(np.nanstd(others, axis=0), 2 * tuning.least_between)


def _typical(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else 0.0
