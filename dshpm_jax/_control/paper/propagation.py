"""Identities carried through the whole recording, and what reappears identified again (section 4.5)."""

import numpy as np

from dshpm_jax._control.paper.dynamic import assign_within, identify_segment
from dshpm_jax._control.partial_labels import PartialLabels
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._geometry import is_seen
from dshpm_jax._requests import Control, FitPoses
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH


def propagate(problem: LabellingProblem, known: PartialLabels, frame: int) -> Control[None]:
    """Follows the trajectories from the key-frame to both ends of the recording.

    An identity lives as long as its trajectory. Wherever new trajectories begin (or, going back, end), lost markers
    are recruited near the places that their segments predict; at every relaxation interval a segment that is lost
    altogether is looked for again.
    """
    t = problem.trajectories
    births = np.unique(t.start[t.start > frame])
    deaths = np.unique(t.stop[t.stop <= frame] - 1)[::-1]
    steps = np.arange(frame, problem.last_frame + 1, problem.relaxation)
    back = np.arange(frame, -1, -problem.relaxation)
    for way, looks in ((np.union1d(births, steps), steps), (np.union1d(deaths, back)[::-1], back)):
        looked = set(looks.tolist())
        for here in way:
            yield from recruit_all(problem, known, int(here))
            if int(here) in looked and here != frame:
                yield from _look_again(problem, known, int(here))


def recruit_all(problem: LabellingProblem, known: PartialLabels, frame: int) -> Control[None]:
    """Recruits lost markers of all segments in `frame` (Fig. 3), all fits in one request."""
    here, points = problem.trajectories.at(frame)
    free = np.flatnonzero(known.unclaimed(here))
    if not len(free):
        return
    wanting, shapes, places, lost = [], [], [], []
    carrying = known.trajectory_of_marker(problem, frame)
    for target in problem.targets:
        found = carrying[target.markers]
        there = found != NO_MATCH
        if there.all() or there.sum() < MIN_FIT_POINTS:
            continue
        wanting.append(target)
        shapes.append(target.shape)
        places.append(problem.trajectories.positions(np.array([frame]), found)[0])
        lost.append(~there)
    if not wanting:
        return
    width = max(map(len, shapes))
    shape, place = (np.stack([_padded(rows, width) for rows in stack]) for stack in (shapes, places))
    poses = yield FitPoses(np.nan_to_num(shape), place, is_seen(place).astype(float))
    predicted = np.einsum("fij,fcj->fci", poses.rotation, np.nan_to_num(shape)) + poses.translation[:, None]
    best: dict[int, tuple[float, np.ndarray, float]] = {}
    for k, target in enumerate(wanting):
        if poses.rank[k] < 2:
            continue
        for column in np.flatnonzero(lost[k]):
            marker, reach = int(target.markers[column]), float(target.reach[column])
            if marker not in best or reach < best[marker][2]:
                best[marker] = (reach, predicted[k, column], reach)
    _take_nearest(problem, known, here[free], points[free], best)


def _take_nearest(problem: LabellingProblem, known: PartialLabels, trajectories, points, wanted) -> None:
    markers = sorted(wanted)
    if not markers:
        return
    near = np.linalg.norm(np.stack([wanted[m][1] for m in markers])[:, None] - points[None], axis=-1)
    for row, column in assign_within(near, np.array([wanted[m][0] for m in markers])):
        trajectory = int(trajectories[column])
        if not known.clashes(problem, trajectory, markers[row]).any():
            known.recruit(trajectory, markers[row])


def _look_again(problem: LabellingProblem, known: PartialLabels, frame: int) -> Control[None]:
    """Looks for every segment of which too little is known in `frame` to predict the rest."""
    carrying = known.trajectory_of_marker(problem, frame)
    for segment, target in enumerate(problem.targets):
        there = carrying[target.markers] != NO_MATCH
        if there.sum() < min(MIN_FIT_POINTS, len(there)):
            yield from identify_segment(problem, known, segment, frame)
            carrying = known.trajectory_of_marker(problem, frame)


def _padded(rows: np.ndarray, width: int) -> np.ndarray:
    return np.concatenate([rows, np.full((width - len(rows), 3), np.nan)])
