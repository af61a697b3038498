"""A small figure for tests of the control: a trunk, an arm and a hand that share join markers, and a short stick."""

from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from dshpm_jax import Segment, SubjectModel
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_PARENT

TRUNK, ARM, HAND, STICK = range(4)
RATE = 60.0

# Places of 12 markers when nothing is bent (mm); 4 is the shoulder, 7 the wrist, 10 the fingertip.
REST = np.array(
    [
        [0, 0, 0], [10, 260, 15], [-25, 40, 430], [60, 180, 300], [0, 330, 480],
        [30, 420, 500], [-40, 520, 465], [5, 640, 490],
        [45, 700, 510], [-20, 735, 450], [15, 800, 500], [20, 800, 620],
    ],
    dtype=float,
)  # fmt: skip
MEMBERS = ((0, 1, 2, 3, 4), (4, 5, 6, 7), (7, 8, 9, 10), (10, 11))
PARENTS = (NO_PARENT, TRUNK, ARM, HAND)
NAMES = ("trunk", "arm", "hand", "stick")


@cache
def model() -> SubjectModel:
    segments = []
    for name, members, parent in zip(NAMES, MEMBERS, PARENTS):
        shape = REST[list(members)]
        join = tuple(m for m in members if parent != NO_PARENT and m in MEMBERS[parent])
        segments.append(Segment(name, members, shape - shape.mean(0), parent, join))
    unknown = np.full((12, 12), np.nan)
    return SubjectModel(tuple(f"M{k}" for k in range(12)), tuple(segments), unknown, unknown)


def motion(frames: int = 60, seed: int = 0) -> np.ndarray:
    """The markers of the figure as it moves (frames, 12, 3), with a little noise."""
    rng = np.random.default_rng(seed)
    points = np.repeat(REST[None], frames, axis=0)
    phase = np.linspace(0, 2 * np.pi, frames)
    for segment, axis, first in ((STICK, [0, 1, 0], 11), (HAND, [1, 0, 0], 8), (ARM, [0, 0, 1], 5)):
        centre = points[:, MEMBERS[segment][0], None]
        turn = Rotation.from_rotvec(0.5 * np.sin(phase + segment)[:, None] * np.array(axis)).as_matrix()
        points[:, first:] = (points[:, first:] - centre) @ turn.transpose(0, 2, 1) + centre
    points = points + 300 * np.stack([np.sin(phase), phase / 3, 0 * phase], -1)[:, None]
    return points + rng.normal(0, 0.3, points.shape)


def problem(points: np.ndarray, **settings) -> LabellingProblem:
    """The problem of a recording; by default for the paper's method."""
    return LabellingProblem(from_columns(points, RATE), model(), Settings(**({"method": "paper"} | settings)))


def trajectory_of(problem: LabellingProblem, frame: int, column: int) -> int:
    """The trajectory that stands in `column` of the recording."""
    here = problem.trajectories.column[frame] == column
    return int(problem.trajectories.index[frame, here][0])


def truth(problem: LabellingProblem, markers: int = 12) -> np.ndarray:
    """The marker of each trajectory, if the first columns of the recording are the markers in order."""
    t = problem.trajectories
    column = t.column[t.start, t.slot]
    return np.where(column < markers, column, -1)
