"""Gaps of markers, filled from the markers that go with them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline

from dshpm_jax._geometry import is_seen, runs, weighted_rigid_fit
from dshpm_jax._model import SubjectModel
from dshpm_jax._reconstruction.rigid import MIN_PLANE_SPREAD_MM, SegmentPoses
from dshpm_jax._recording import Recording
from dshpm_jax._types import MIN_FIT_POINTS

CONTEXT_SECONDS, MIN_CONTEXT = 0.04, 3
"""s and count; used in `fill`: this long before and after a gap, and at least this number of frames, tell how fast a
marker moved there; by hand."""

SLIDE_SECONDS = 0.1
"""s; used in `fill`: a marker that slides on its body at the end of a gap goes on for about this time; by hand."""

SPLINE_SECONDS = 0.08
"""s; used in `fill`: over gaps of this length a spline through the room counts as much as the markers around; by hand:
it errs as much there, and over longer gaps far more."""


class Filled(NamedTuple):
    """A recording whose gaps are filled, and what is not measured in it.

    Attributes:
        recording: points in millimetres; measured ones are as they were.
        mask: which points were filled.
    """

    recording: Recording
    mask: Bool[np.ndarray, "frames points"]


class _Body(NamedTuple):
    """Something rigid that a marker goes with: its pose in each frame, and the marker's usual place on it (mm)."""

    rotation: Float[np.ndarray, "frames 3 3"]
    translation: Float[np.ndarray, "frames 3"]
    place: Float[np.ndarray, "3"]


def marker_points(recording: Recording, model: SubjectModel) -> Float[np.ndarray, "frames markers 3"]:
    """The points of each marker of the model (mm), NaN where it is not seen."""
    columns = _marker_columns(recording, model)
    points = np.full((recording.num_frames, model.num_markers, 3), np.nan)
    points[:, list(columns)] = recording.points[:, list(columns.values())]
    points[~is_seen(points)] = np.nan
    return points


def _marker_columns(recording: Recording, model: SubjectModel) -> dict[int, int]:
    """The column of each marker of the model that the recording has."""
    return {m: recording.labels.index(name) for m, name in enumerate(model.markers) if name in recording.labels}


def fill(recording: Recording, model: SubjectModel, poses: SegmentPoses, max_seconds: float | None = None) -> Filled:
    """Fills what `poses` and the markers around allow; see `Motion.filled`."""
    longest = recording.num_frames if max_seconds is None else max_seconds * recording.rate
    points, seen = np.array(recording.points, np.float64), recording.present
    measured = marker_points(recording, model)
    for marker, column in _marker_columns(recording, model).items():
        if seen[:, column].any():
            for start, stop in runs(~seen[:, column]):
                if stop - start <= longest:
                    path = path_through(model, measured, poses, recording.rate, marker, start, stop)
                    points[start:stop, column] = path
    there = is_seen(points)
    return Filled(replace(recording, points=points), np.asarray(there & ~seen))


def context_frames(rate: float) -> int:
    """Frames before and after a gap that tell how fast a marker moved there."""
    return max(MIN_CONTEXT, round(CONTEXT_SECONDS * rate))


def path_through(
    model: SubjectModel, measured: np.ndarray, poses: SegmentPoses, rate: float, marker: int, start: int, stop: int
) -> Float[np.ndarray, "gap 3"]:
    """Where a marker was in a gap (mm), NaN where nothing says so."""
    context = context_frames(rate)
    window = slice(max(0, start - context), min(len(measured), stop + context))
    times = (np.arange(window.start, window.stop) - start) / rate
    gap = slice(start - window.start, stop - window.start)
    seen = measured[window, marker]
    body = _neighbours(model, measured[window], marker) or _segment(model, poses, measured, window, marker)
    if body is None:
        return np.full((stop - start, 3), np.nan)
    local = np.einsum("fji,fj->fi", body.rotation, seen - body.translation)
    slid = _slide(times, local, gap, body.place)
    path = np.einsum("fij,fj->fi", body.rotation[gap], slid) + body.translation[gap]
    ends = np.isfinite(seen[:, 0])
    if not (ends[: gap.start].any() and ends[gap.stop :].any()):
        return path
    trust = 1 / (1 + ((stop - start) / rate / SPLINE_SECONDS) ** 4)
    return np.where(np.isfinite(path), path + trust * (CubicSpline(times[ends], seen[ends])(times[gap]) - path), np.nan)


def _neighbours(model: SubjectModel, window: Float[np.ndarray, "frames markers 3"], marker: int) -> _Body | None:
    """The markers that go best with this one and are seen throughout, if they are enough for a pose.

    The same ones in every frame: with one that comes or goes, all would jump.
    """
    if not model.neighbourhoods:
        return None
    near = model.neighbourhoods[marker]
    there = [k for k, other in enumerate(near.markers) if np.isfinite(window[:, other]).all()]
    if len(there) < MIN_FIT_POINTS:
        return None
    others = window[:, [near.markers[k] for k in there]]
    rotation, translation, spread = weighted_rigid_fit(near.shape[there], others, 1 / near.distance_sd[there] ** 2)
    return _Body(rotation, translation, near.shape[-1]) if spread.min() >= MIN_PLANE_SPREAD_MM else None


def _segment(
    model: SubjectModel, poses: SegmentPoses, measured: np.ndarray, window: slice, marker: int
) -> _Body | None:
    """The segment of the marker that has a pose in most frames, of several the one of which most is seen."""
    best, most = None, (0, 0)
    for s, segment in enumerate(model.segments):
        if marker in segment.markers:
            posed = int(np.isfinite(poses.translations[window, s, 0]).sum())
            score = posed, int(np.isfinite(measured[window, list(segment.markers), 0]).sum())
            if posed and score > most:
                place = segment.shape[segment.markers.index(marker)]
                best, most = _Body(poses.rotations[window, s], poses.translations[window, s], place), score
    return best


def _slide(times: np.ndarray, local: Float[np.ndarray, "frames 3"], gap: slice, place: np.ndarray) -> np.ndarray:
    """Where the marker is on its body during the gap: on the way from one end of it to the other.

    It leaves an end as fast as it came there, and slows down. A gap with one end keeps what it has there, and one
    with none the marker's usual place.
    """
    known = np.isfinite(local[:, 0])
    before, after = np.flatnonzero(known[: gap.start]), gap.stop + np.flatnonzero(known[gap.stop :])
    count = gap.stop - gap.start
    if not len(before) or not len(after):
        end = local[before[-1]] if len(before) else local[after[0]] if len(after) else place
        return np.broadcast_to(end, (count, 3))
    first, last = before[-1], after[0]
    span = times[last] - times[first]
    share = ((times[gap] - times[first]) / span)[:, None]
    since, until = share * span, (1 - share) * span
    speed = (local[last] - local[first]) / span
    leaving, coming = _speed(times[before], local[before], speed), _speed(times[after], local[after], speed)
    straight = local[first] + share * (local[last] - local[first])
    start = (leaving - speed) * since * (1 - share) * np.exp(-since / SLIDE_SECONDS)
    end = (coming - speed) * until * share * np.exp(-until / SLIDE_SECONDS)
    return straight + start - end


def _speed(times: np.ndarray, local: np.ndarray, otherwise: np.ndarray) -> Float[np.ndarray, "3"]:
    """The slope of a line through the places of some frames (mm/s); `otherwise` if there is one frame only."""
    if len(times) < 2:
        return otherwise
    about = times - times.mean()
    return about @ local / (about @ about)
