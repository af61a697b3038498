"""How far off a filled gap is likely to be: gaps of its length are opened where the marker is seen, and filled."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.interpolate import CubicSpline

from dshpm_jax._geometry import every_nth, is_seen
from dshpm_jax._reconstruction.filling import context_frames, marker_points, path_through
from dshpm_jax._reconstruction.motion import Motion
from dshpm_jax._reconstruction.rigid import SegmentPoses

TRIES = 8
"""count; used in `ExpectedErrors`: gaps that are opened for one that is filled, at most; by hand: more change the mean
by less than it is off."""


class GapErrors(NamedTuple):
    """Root mean square errors that a filled gap is likely to have (mm); None where nothing tells.

    Attributes:
        body: of our filling, from the markers that go with this one.
        spline: of a cubic spline through the frames before and after.
    """

    body: float | None
    spline: float | None


class ExpectedErrors:
    """Tells expected errors of filled gaps of one motion.

    The markers that are missing in the gap are left out of the opened gaps as well. Poses of segments are those that
    the whole recording gave, so where these fill a gap the error is a little too low.
    """

    def __init__(self, motion: Motion):
        self._motion = motion
        self._points = marker_points(motion.recording, motion.model)
        self._seen = is_seen(self._points)
        self._context = context_frames(motion.recording.rate)

    def of(self, marker: int, start: int, stop: int) -> GapErrors:
        """The errors of a gap of a marker in the frames `start <= t < stop`."""
        missing = np.logical_not(self._seen[start:stop].any(0))
        errors = [
            self._error(marker, int(first), stop - start, missing) for first in self._places(marker, stop - start)
        ]
        body, spline = (np.array([one[k] for one in errors], float) for k in range(2))
        return GapErrors(_mean(body), _mean(spline))

    def _places(self, marker: int, length: int) -> Int[np.ndarray, " places"]:
        """Where a gap can be opened: the marker is seen throughout, and before and behind it."""
        whole = length + 2 * self._context
        count = np.concatenate([[0], np.cumsum(self._seen[:, marker])])
        full = np.flatnonzero(count[whole:] - count[:-whole] == whole) if len(count) > whole else np.zeros(0, int)
        return full[every_nth(len(full), TRIES)] + self._context

    def _error(
        self, marker: int, start: int, length: int, missing: Bool[np.ndarray, " markers"]
    ) -> tuple[float, float]:
        """Of ours and of a spline."""
        first, last = start - self._context, start + length + self._context
        points = self._points[first:last].copy()
        gap = slice(self._context, self._context + length)
        truth = points[gap, marker].copy()
        points[gap, missing] = points[gap, marker] = np.nan
        poses = SegmentPoses(self._motion.rotations[first:last], self._motion.translations[first:last])
        rate = self._motion.recording.rate
        ours = path_through(self._motion.model, points, poses, rate, marker, gap.start, gap.stop)
        times, ends = np.arange(last - first), np.ones(last - first, bool)
        ends[gap] = False
        spline = CubicSpline(times[ends], points[ends, marker])(times[gap])
        return _rms(ours - truth), _rms(spline - truth)


def _rms(apart: Float[np.ndarray, "gap 3"]) -> float:
    return float(np.sqrt((apart**2).sum(1).mean()))


def _mean(errors: Float[np.ndarray, " places"]) -> float | None:
    known = errors[np.isfinite(errors)]
    return round(float(known.mean()), 2) if len(known) else None
