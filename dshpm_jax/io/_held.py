"""Gaps that a program held at the last value: the point stands still to the last bit while the others move."""

import numpy as np
from jaxtyping import Bool, Float

from dshpm_jax._geometry import is_seen, runs

HELD_FRAMES = 3
"""Frames; used in `held_points`: coordinates that stay the same to the last bit for fewer may do so by chance."""

FINEST_MM, COARSEST_MM = 0.02, 1.0
"""Millimetres, of the step in which numbers are written; used in `held_points`: above the first a point at rest stays
the same for many frames, and only a leap tells; above the second nothing does. Noise of the best systems is about 0.02
mm in each direction."""

STEPS_OF_A_LEAP = 5
"""Of the steps in which numbers are written; used in `held_points`: less may be one of a slow motion."""

MOST_VALUES = 100_000
"""Coordinates; used in `_resolution`: more say nothing new."""

MOVING_SHARE = 0.5
"""Of the other points that are seen; used in `held_points`: with fewer of them moving, the capture stands still."""

LEAST_LEAP_MM = 1.0
"""Millimetres; used in `held_points`: a point that is so near where it was has lost nothing. Some systems give a foot
at rest the same numbers for several frames."""

LEAST_FACTOR, FACTOR, MOST_FACTOR = 2.2, 0.5, 5.0
"""No unit; used in `_measured`: after a gap of n frames a point has n + 1 usual steps to make up for, unless it came
back meanwhile. Such a share of them must be in the leap, and so many usual steps at least and at most. A point at rest
that changes by fits and starts makes one or two."""

STEPS_AROUND = 3
"""Frames; used in `_measured`: on either side, from which the usual step is taken."""


def held_points(points: Float[np.ndarray, "frames points 3"]) -> Bool[np.ndarray, "frames points"]:
    """Where a point of a moving capture keeps its coordinates to the last bit for several frames, and then leaps.

    The first frame of those, before the gap, is the one that was measured, or the last where the leap comes before
    them. A column that never changes holds no gap, and neither does a recording whose numbers are too coarse to tell.
    """
    seen = is_seen(points)
    held = np.zeros(seen.shape, bool)
    if len(points) < HELD_FRAMES:
        return held
    both = seen[1:] & seen[:-1]
    same = both & (points[1:] == points[:-1]).all(-1)
    moving = both & ~same
    written = _resolution(points) if same.any() else np.inf
    if written > COARSEST_MM:
        return held
    least = max(LEAST_LEAP_MM, STEPS_OF_A_LEAP * written)
    live = moving.sum(1) > MOVING_SHARE * np.maximum(both.sum(1) - 1, 0)
    quiet = same & live[:, None] & moving.any(0)
    for column in np.flatnonzero(quiet.any(0)):
        steps = np.linalg.norm(np.diff(points[:, column], axis=0), axis=-1)
        for first, last in runs(quiet[:, column]):
            measured = _measured(steps, first, last, least) if last - first + 1 >= HELD_FRAMES else None
            if measured is not None and (written <= FINEST_MM or _between(steps, first, last)):
                held[first : last + 1, column] = True
                held[measured, column] = False
    return held


def _resolution(points: Float[np.ndarray, "frames points 3"]) -> float:
    """The step in which the file writes its numbers, or less: the smallest difference of two coordinates (mm)."""
    values = points[np.isfinite(points)]
    apart = np.diff(np.unique(values[:: max(1, len(values) // MOST_VALUES)]))
    return float(apart.min(initial=np.inf))


def _between(steps: Float[np.ndarray, " steps"], first: int, last: int) -> bool:
    """Whether the point is seen right before and right behind."""
    return 0 < first and last < len(steps) and bool(np.isfinite(steps[[first - 1, last]]).all())


def _measured(steps: Float[np.ndarray, " steps"], first: int, last: int, least: float) -> int | None:
    """The one frame that was measured of `first` to `last`, in which a point is the same; None where it is at rest.

    Arguments:
        steps: how far the point goes from each frame to the next (mm), NaN where it is not seen in both.
        least: a leap (mm); a point that is nearer to where it was has lost nothing.
    """
    before, after = slice(max(0, first - 1 - STEPS_AROUND), max(0, first - 1)), slice(last + 1, last + 1 + STEPS_AROUND)
    around = np.concatenate([steps[before], steps[after]])
    usual = float(np.median(around[around > 0])) if (around > 0).any() else 0.0
    opening = float(steps[first - 1]) if first else np.nan
    closing = float(steps[last]) if last < len(steps) else np.nan
    farthest = max(least, float(np.clip(FACTOR * (last - first + 1), LEAST_FACTOR, MOST_FACTOR)) * usual)
    if max(np.nan_to_num(opening), np.nan_to_num(closing)) > farthest:
        return first if not opening > closing else last
    if np.isfinite(opening) == np.isfinite(closing) or usual * (last - first) <= least:
        return None
    return first if np.isfinite(opening) else last  # nothing tells how far it went, but it never went so slowly
