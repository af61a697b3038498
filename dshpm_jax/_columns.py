"""Columns of a recording as trajectories: whether they are any, and where they have to be cut; plain numpy."""

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial.distance import cdist

from dshpm_jax._geometry import every_nth, is_seen
from dshpm_jax._types import NO_MATCH

ACCELERATION = 150e3
"""mm/s^2; used in `unbroken_columns` and by the tracker: what it moves a point in a frame, a prediction may miss by; by
hand: impacts exceed it, and then the neighbours' deviation helps."""

SPEED = 20e3
"""mm/s; used in `unbroken_columns` and by the tracker: if nothing is known of a point, it may go no farther; derived: a
foot in a sprint."""

SAMPLED_FRAMES = 60
"""count; used in `columns_are_tracks`: pairs of consecutive frames by which columns are judged, at most; by hand."""

OWN_NEAREST = 0.25
"""share; used in `columns_are_tracks`: if fewer points than this, beyond chance, are nearest to their own column's next
point, the columns carry nothing; by hand: real trajectories score .33 to 1, shuffled points nearly 0."""

JUMP = 60.0
"""mm; used in `unbroken_columns`: if a column leaves its course by more than this beyond what acceleration explains, it
is cut; by hand."""

RIVAL_RATIO = 3.0
"""factor; used in `unbroken_columns`: if another column's next point is this many times nearer to the course of a
suspect, that one is cut; by hand."""

SUSPECT = 25.0
"""mm; used in `unbroken_columns`: if a column's step is off its course by no more than this, it is not compared with
others; by hand."""


def columns_are_tracks(points: Float[np.ndarray, "frames points 3"]) -> bool:
    """Whether the columns carry trajectories already.

    In pairs of consecutive frames, spread over the recording, we count the points seen in both whose own column holds
    the nearest point of the second frame, and take off what chance gives them, one over the number of points. Real
    trajectories score nearly 1, and still a third for dense markers in a sprint at 60 Hz, where neighbours overrun each
    other in a frame; shuffled points score nearly 0. Only steps count, so fragments of two frames are judged as well as
    long columns, and a column that stands still is its own nearest point. Columns in which no two consecutive frames
    are filled carry nothing, unless no frame follows another at all.
    """
    present = is_seen(points)
    steps = np.logical_and(present[:-1], present[1:])
    own = total = chance = 0.0
    stepped = np.flatnonzero(steps.any(1))
    for t in stepped[every_nth(len(stepped), SAMPLED_FRAMES)]:
        columns, following = np.flatnonzero(steps[t]), np.flatnonzero(present[t + 1])
        distance = cdist(points[t, columns], points[t + 1, following])
        nearest = distance.min(1) >= distance[np.arange(len(columns)), np.searchsorted(following, columns)]
        if len(following) > 1:  # a lone point is nearest in any case
            own, total, chance = own + nearest.sum(), total + len(columns), chance + len(columns) / len(following)
    if total:
        return bool(own - chance >= OWN_NEAREST * (total - chance))
    filled = np.any(present, axis=1)
    return bool(steps.any()) or not np.logical_and(filled[:-1], filled[1:]).any()


def unbroken_columns(points: Float[np.ndarray, "frames points 3"], rate: float) -> Int[np.ndarray, "frames points"]:
    """Links of the columns with themselves, cut at gaps and where a column leaves its course.

    The course of a column is its last step once more, or standing still in its second frame. It is left where the next
    point

    - is farther from the point before than a foot moves in a sprint, or
    - misses the course by more than the acceleration of a marker explains and `JUMP` besides, or
    - misses it by more than `SUSPECT`, while another column's point lies `RIVAL_RATIO` times nearer to it that is off
      its own column's course too, or has none: two columns that swap, or a marker that goes on in another column.

    The step after a cut is judged by the step that was cut, so as a rule it is cut too and leaves a single point.
    """
    present = is_seen(points)
    steps = present.copy()
    steps[:-1] &= present[1:]
    steps[-1:] = False
    frame, column = np.nonzero(steps)  # few, where every trajectory has a column of its own
    here = points[frame, column]
    step = points[frame + 1, column] - here
    known = np.append(np.zeros((1, steps.shape[1]), bool), steps[:-1], axis=0)[frame, column]
    before = np.where(known[:, None], here - points[frame - 1, column], 0.0)
    miss = np.linalg.norm(step - before, axis=-1)
    cut = np.linalg.norm(step, axis=-1) > SPEED / rate + JUMP
    cut |= known & (miss > ACCELERATION / rate**2 + JUMP)
    on_course = known & (miss <= SUSPECT)
    free = present  # points that no column claims by being on its course
    free[frame[on_course] + 1, column[on_course]] = False
    off = np.flatnonzero(known & (miss > SUSPECT))
    cut[off] |= _taken_over(points, frame[off], column[off], (here + before)[off], miss[off], free)
    links = np.full(steps.shape, NO_MATCH, np.int32)
    links[frame[~cut], column[~cut]] = column[~cut]
    return links


def _taken_over(points, frame, column, course, miss, free) -> Bool[np.ndarray, " suspects"]:
    """Where another column's next point is on the course of a column that is off it.

    Arguments:
        frame, column, course, miss: of the suspects, by frame.
        free: points that no column claims.
    """
    found = np.zeros(len(frame), bool)
    ends = np.flatnonzero(np.diff(frame, append=-1)) + 1
    for some in map(slice, np.append(0, ends[:-1]), ends):
        t = frame[some.start]
        following = np.flatnonzero(free[t + 1])
        if len(following):
            distance = cdist(course[some], points[t + 1, following])
            distance[column[some, None] == following[None]] = np.inf
            found[some] = RIVAL_RATIO * distance.min(1) < miss[some]
    return found
