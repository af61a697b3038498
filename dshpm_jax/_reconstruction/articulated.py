"""Segments that are short of points, fitted to their markers, to their joints and to the poses before and after.

A robust least-squares fit over a tree, by turns: each segment is fitted (optimistix) with its neighbours where they
were last, those at even depth of the tree and then those at odd depth, so that no two neighbours move at once and all
frames are solved side by side in one compiled program.
"""

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix
from jaxtyping import Array, Bool, Float

from dshpm_jax._geometry import is_seen
from dshpm_jax._hierarchy import depth_first
from dshpm_jax._model import SubjectModel
from dshpm_jax._reconstruction.interpolation import Between
from dshpm_jax._reconstruction.rigid import SegmentPoses, marker_sd
from dshpm_jax._types import NO_MATCH, NO_PARENT

MIN_TIES = 2
"""count; used in `fit_articulated`: if fewer points of a segment are known than this (markers, and joints with segments
whose pose is known), it is not fitted; by hand."""

TURNS = 3
"""count; used in `fit_articulated`: rounds over the tree after the first; by hand: poses change by some tenths of a
millimetre then."""

LIMIT = 3.0
"""standard deviations; used in `solve`: from here on, a marker pulls hardly more the further away it is (pseudo-Huber);
by hand: a wrong one does little harm, and a right one is still found from a guess far off."""

MIN_JOINT_MM = 3.0
"""mm; used in `fit_articulated`: if the model has a joint's spread less than this, this counts; by hand."""

TURN, TURN_A_SECOND, SHIFT_MM = 0.05, 2.0, 200.0
"""rad, rad/s, mm; used in `fit_articulated`: by how much the guess may be off: its turn next to a known pose, what is
added for each second from it, and its place; by hand."""

LEVER_MM = 100.0
"""mm; used in `solve`: a turn is measured by what it moves at this distance; derived: turns and shifts are of one size
then."""

MAX_STEPS = 32
"""count; used in `solve`: steps of Levenberg and Marquardt, at most; by hand."""

STEP_RTOL, STEP_ATOL_MM = 1e-2, 0.05
"""share and mm; used in `solve`: if a step is smaller than both together, the fit is done; by hand."""

LANES, TIES = 256, 16  # problems in one call; ties of each are padded to a multiple of so many


class PoseProblems(NamedTuple):
    """Bodies near where they are guessed to be, tied to places in the world; lengths are mm.

    Attributes:
        rotation, translation: the guess.
        stiffness: of the guess: one over the turn (rad) and over the shift by which it may be off.
        here: places on the body,
        there: and where these should be.
        weight: one over the usual length of each tie, 0 for none.
        robust: 1 where a tie may be wrong, else 0.
    """

    rotation: Float[np.ndarray, "lanes 3 3"]
    translation: Float[np.ndarray, "lanes 3"]
    stiffness: Float[np.ndarray, "lanes 2"]
    here: Float[np.ndarray, "lanes ties 3"]
    there: Float[np.ndarray, "lanes ties 3"]
    weight: Float[np.ndarray, "lanes ties"]
    robust: Float[np.ndarray, "lanes ties"]


class Tie(NamedTuple):
    """What holds a segment at `here`, in its own frame (mm).

    Either `marker` where it is seen, or, where `marker` is not seen or none, the place `there` on `neighbour`.
    """

    here: Float[np.ndarray, "3"]
    marker: int
    neighbour: int
    there: Float[np.ndarray, "3"]
    sd: float


def fit_articulated(
    model: SubjectModel,
    points: Float[np.ndarray, "frames markers 3"],
    measured: Bool[np.ndarray, "frames segments"],
    way: Between,
    rate: float,
) -> tuple[SegmentPoses, Bool[np.ndarray, "frames segments"]]:
    """Poses where segments are not `measured` but tied well enough, and which these are.

    Segments that have a pose in no frame at all have nothing to start from and stay without.
    """
    poses = SegmentPoses(way.poses.rotations.copy(), way.poses.translations.copy())
    turn = TURN + TURN_A_SECOND * np.minimum(way.distance, 1e6) / rate
    stiffness = np.stack(np.broadcast_arrays(1 / turn, 1 / SHIFT_MM), axis=-1)
    ties = [list(_ties(model, s)) for s in range(len(model.segments))]
    known, guess = measured.copy(), way.poses
    possible = is_seen(guess.translations) & ~measured

    def settle(segments: list[int], wanted: np.ndarray) -> bool:
        """Fits the `wanted` frames of some segments, no two of them neighbours."""
        lanes = [(s, np.flatnonzero(wanted[:, s])) for s in segments if wanted[:, s].any()]
        made = [_problems(ties[s], points, poses, known, guess, stiffness, s, frames, most) for s, frames in lanes]
        if made:
            rotation, translation = solve(PoseProblems(*(np.concatenate(field) for field in zip(*made))))
            at_frame = np.concatenate([frames for _, frames in lanes])
            at_segment = np.repeat([s for s, _ in lanes], [len(frames) for _, frames in lanes])
            poses.rotations[at_frame, at_segment] = rotation
            poses.translations[at_frame, at_segment] = translation
            known[at_frame, at_segment] = True
        return bool(made)

    most = -(-max(map(len, ties)) // TIES) * TIES
    sides = _sides(model)
    while any([settle(side, possible & ~known & _tied(ties, points, known)) for side in sides]):
        pass
    found = known & ~measured
    for _ in range(TURNS):
        for side in sides:
            settle(side, found)
    return poses, found


def _sides(model: SubjectModel) -> tuple[list[int], list[int]]:
    """Segments at even and at odd depth of the tree."""
    depth = {NO_PARENT: -1}
    for s in depth_first(model.segments):
        depth[s] = depth[model.segments[s].parent] + 1
    order = range(len(model.segments))
    return [s for s in order if depth[s] % 2 == 0], [s for s in order if depth[s] % 2]


def _ties(model: SubjectModel, segment: int) -> Iterator[Tie]:
    """The markers of a segment, and its joints with its parent and its children."""
    own = model.segments[segment]
    sd = dict(zip(own.markers, marker_sd(model, own.markers)))
    for marker, place in zip(own.markers, own.shape):
        yield Tie(place, marker, NO_MATCH, place, sd[marker])
    for child, below in enumerate(model.segments):
        if below.parent == NO_PARENT or segment not in (child, below.parent):
            continue
        above = model.segments[below.parent]
        neighbour = below.parent if segment == child else child
        join = below.virtual_join
        if join is not None:
            here, there = (join.in_segment, join.in_parent) if segment == child else (join.in_parent, join.in_segment)
            yield Tie(here, NO_MATCH, neighbour, there, max(join.spread, MIN_JOINT_MM))
        for marker in below.join:
            places = (above.shape[above.markers.index(marker)], below.shape[below.markers.index(marker)])
            here, there = places[::-1] if segment == child else places
            yield Tie(here, marker, neighbour, there, sd[marker])


def _tied(ties: list[list[Tie]], points: np.ndarray, known: np.ndarray) -> Bool[np.ndarray, "frames segments"]:
    """Which segments have enough ties: markers that are seen, and neighbours whose pose is known."""
    seen = is_seen(points)
    count = np.zeros(known.shape, dtype=int)
    for s, mine in enumerate(ties):
        count[:, s] += seen[:, [tie.marker for tie in mine if tie.neighbour == NO_MATCH]].sum(1)
        count[:, s] += known[:, sorted({tie.neighbour for tie in mine} - {NO_MATCH})].sum(1)
    return count >= MIN_TIES


def _problems(
    ties: list[Tie],
    points: np.ndarray,
    poses: SegmentPoses,
    known: np.ndarray,
    guess: SegmentPoses,
    stiffness: np.ndarray,
    segment: int,
    frames: np.ndarray,
    most: int,
) -> PoseProblems:
    """One problem for each of some frames of a segment, padded to `most` ties."""
    there, weight = np.zeros((len(frames), most, 3)), np.zeros((len(frames), most))
    here, robust = np.zeros((most, 3)), np.zeros(most)
    for k, tie in enumerate(ties):
        here[k], robust[k] = tie.here, tie.neighbour == NO_MATCH
        place = points[frames, tie.marker] if tie.marker != NO_MATCH else np.full((len(frames), 3), np.nan)
        seen = is_seen(place)
        if tie.neighbour == NO_MATCH:
            holds = seen
        else:
            place = poses.place(tie.neighbour, tie.there, frames)
            holds = known[frames, tie.neighbour] & ~seen  # a marker that is seen holds both by itself
        there[holds, k], weight[holds, k] = place[holds], 1 / tie.sd
    return PoseProblems(
        guess.rotations[frames, segment],
        guess.translations[frames, segment],
        stiffness[frames, segment],
        np.broadcast_to(here, there.shape),
        there,
        weight,
        np.broadcast_to(robust, weight.shape),
    )


def solve(problems: PoseProblems) -> tuple[Float[np.ndarray, "lanes 3 3"], Float[np.ndarray, "lanes 3"]]:
    """The rotation and translation (mm) of each body that its ties and its guess make likeliest.

    Solved near the origin in float32, `LANES` at a time.
    """
    lanes = len(problems.translation)
    centre = problems.translation
    near = problems._replace(translation=np.zeros_like(centre), there=problems.there - centre[:, None])
    solver, found = _solver(), []
    for first in range(0, lanes, LANES):
        rows = np.arange(first, first + LANES) % lanes  # the last call starts again rather than compile another size
        rotation, translation = solver(PoseProblems(*(x[rows].astype(np.float32) for x in near)))
        found.append((np.asarray(rotation, np.float64), np.asarray(translation, np.float64)))
    rotation, translation = (np.concatenate(parts)[:lanes] for parts in zip(*found))
    return rotation, translation + centre


@cache
def _solver():
    return eqx.filter_jit(jax.vmap(_solve_one))


def _solve_one(problem: PoseProblems) -> tuple[Float[Array, "3 3"], Float[Array, "3"]]:
    solver = optimistix.LevenbergMarquardt(rtol=STEP_RTOL, atol=STEP_ATOL_MM)
    start = jnp.zeros(6, jnp.float32)
    # The last step of one that does not settle is still better than its guess, so nothing is thrown.
    solution = optimistix.least_squares(_residuals, solver, start, problem, max_steps=MAX_STEPS, throw=False)
    return _moved(problem, solution.value)


def _moved(problem: PoseProblems, step: Float[Array, "6"]) -> tuple[Float[Array, "3 3"], Float[Array, "3"]]:
    """The pose after a turn (about an axis, times the lever) and a shift."""
    return _rotation(step[:3] / LEVER_MM) @ problem.rotation, jnp.asarray(problem.translation) + step[3:]


def _rotation(vector: Float[Array, "3"]) -> Float[Array, "3 3"]:
    """The rotation of the quaternion (1, vector / 2): by that vector for small angles, and smooth everywhere."""
    x, y, z = vector / 2
    cross = jnp.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]], vector.dtype)
    return jnp.eye(3, dtype=vector.dtype) + 2.0 / (1.0 + x * x + y * y + z * z) * (cross + cross @ cross)


def _residuals(step: Float[Array, "6"], problem: PoseProblems) -> tuple[Float[Array, "ties 3"], Float[Array, "2 3"]]:
    rotation, translation = _moved(problem, step)
    apart = (jnp.asarray(problem.here) @ rotation.T + translation[None] - problem.there) * problem.weight[:, None]
    excess = problem.robust * jnp.sum(apart**2, axis=1) / LIMIT**2
    apart = apart * jnp.sqrt(2.0 / (1.0 + jnp.sqrt(1.0 + excess)))[:, None]
    turned_and_moved = step.reshape(2, 3) / jnp.array([[LEVER_MM], [1.0]], step.dtype)
    return apart, turned_and_moved * problem.stiffness[:, None]
