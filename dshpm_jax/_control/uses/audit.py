"""Audits labels that are there: where others explain the recording decidedly better, and where none fits."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Int
from scipy.sparse.csgraph import connected_components

from dshpm_jax._columns import unbroken_columns
from dshpm_jax._control.full.evidence import evidence_in
from dshpm_jax._control.full.moves import Move, judge_moves
from dshpm_jax._control.full.objective import Incumbent, Solution
from dshpm_jax._control.full.refine import improve, refine_labels
from dshpm_jax._control.full.search import solve
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._control.uses.spikes import leaps, spikes
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._requests import Control
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import Trajectories, from_columns
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True, eq=False)
class Doubt:
    """A column whose label is wrong in some frames.

    Attributes:
        column: of the recording.
        first, last: frames, both belong to it.
        should_be: the marker that the point is, `NO_MATCH` if it is none, or off its place.
        nats: how decisive that is; see `Tuning.decisive_llr` and `Tuning.spike_llr`.
    """

    column: int
    first: int
    last: int
    should_be: int
    nats: float


def audit(
    recording: Recording, model: SubjectModel, settings: Settings, tuning: Tuning = TUNING
) -> Control[list[Doubt]]:
    """Every `Doubt` about the labels of `recording`, in the order of columns and frames.

    The recording is labelled as if it had no names, and once more from the names that it has; the better of the two by
    the objective, which needs no truth, is held against the file, difference by difference.
    """
    place = {name: k for k, name in enumerate(model.markers)}
    names = np.array([place.get(label, NO_MATCH) for label in recording.labels])
    tracks = yield from _tracks(recording, model, settings, tuning, names)
    problem = LabellingProblem(tracks, model, settings, tuning)
    own = Incumbent((yield from refine_labels(problem, names[_columns(tracks)])))
    yield from improve(problem, own)
    problem, solution = yield from solve(problem, own.solution)
    tracks = problem.trajectories
    given = names[_columns(tracks)]
    groups = _groups(tracks, given, solution.identity)
    back = [Move(group, given[group], 0.0) for group in groups]
    loss = (yield from judge_moves(problem, solution, back)) if back else []
    kept = _without_smooth_changes(recording, tracks, given, solution.identity, tuning.leap_mm)
    solution = replace(solution, identity=kept)
    found = [d for group, lost in zip(groups, loss) for d in _doubts(problem, solution, given, group, -lost)]
    sound = np.where(solution.identity == given, given, NO_MATCH)
    llr = yield from _own_llr(problem, solution.identity, recording.points.shape[:2])
    llr[tracks.by_column(sound, llr.shape[1]) == NO_MATCH] = np.nan
    off = spikes(llr, recording.points, recording.rate, tuning)
    found += [Doubt(column, first, last, NO_MATCH, fall) for column, first, last, fall in off]
    return _joined(sorted(found, key=lambda d: (d.column, d.first)), recording)


def _columns(tracks: Trajectories) -> Int[np.ndarray, " trajectories"]:
    return tracks.column[tracks.start, tracks.slot]


def _tracks(
    recording: Recording, model: SubjectModel, settings: Settings, tuning: Tuning, names: np.ndarray
) -> Control[Trajectories]:
    """The columns, cut at gaps and jumps and where the evidence for their own labels breaks."""
    points = recording.points
    links = unbroken_columns(points, recording.rate)
    tracks = from_columns(points, recording.rate, links)
    problem = LabellingProblem(tracks, model, settings, tuning)
    own = yield from _own_llr(problem, names[_columns(tracks)], points.shape[:2])
    with np.errstate(invalid="ignore"):
        broken = np.abs(np.diff(own, axis=0)) > tuning.break_llr
    links[:-1][broken] = NO_MATCH
    return from_columns(points, recording.rate, links)


def _own_llr(problem: LabellingProblem, identity: np.ndarray, shape: tuple[int, int]) -> Control[np.ndarray]:
    """Evidence for the label of every labelled point of the recording, NaN for the others."""
    tracks = problem.trajectories
    found = yield from evidence_in(problem, identity, np.arange(tracks.num_frames))
    frame, slot = np.nonzero(found.labels != NO_MATCH)
    own = np.full(shape, np.nan)
    own[frame, tracks.column[frame, slot]] = found.llr[frame, slot, found.labels[frame, slot]]
    return own


def _without_smooth_changes(
    recording: Recording, tracks: Trajectories, given: np.ndarray, found: np.ndarray, leap_mm: float
) -> Int[np.ndarray, " trajectories"]:
    """`found` with the label given wherever a column would change its label without a leap of its point."""
    # Evidence also breaks where neighbours come and go, but a point that goes on smoothly is no other than before.
    smooth = leaps(recording.points) <= leap_mm
    kept = found.copy()
    at = tracks.by_column(np.arange(len(tracks)), recording.points.shape[1])
    frame, column = np.nonzero(smooth & (at[:-1] != at[1:]) & (at[:-1] != NO_MATCH) & (at[1:] != NO_MATCH))
    for one, other in zip(at[frame, column], at[frame + 1, column]):
        for changed, same in ((one, other), (other, one)):
            if found[same] == given[same] and found[changed] != NO_MATCH:
                kept[changed] = given[changed]
    return kept


def _groups(tracks: Trajectories, given: np.ndarray, found: np.ndarray) -> list[Int[np.ndarray, " trajectories"]]:
    """Trajectories whose labels differ, together where one's label is the other's at the same time."""
    differ = np.flatnonzero(given != found)
    start, stop = tracks.start[differ], tracks.stop[differ]
    linked = (start[:, None] < stop[None]) & (start[None] < stop[:, None])
    labels = [set(pair) - {NO_MATCH} for pair in zip(given[differ].tolist(), found[differ].tolist())]
    linked &= np.array([[bool(a & b) for b in labels] for a in labels], bool).reshape(linked.shape)
    count, group = connected_components(linked, directed=False)
    return [differ[group == k] for k in range(count)]


def _doubts(
    problem: LabellingProblem, solution: Solution, given: np.ndarray, group: np.ndarray, gain: float
) -> list[Doubt]:
    """What is wrong in a group, if that is decisive: where the other labels are better, or the one there is nowhere.

    `gain` is by how much the labels found are better than those of the file (nat frames).
    """
    tracks, tuning, frames = problem.trajectories, problem.tuning, solution.evidence.frames
    mean = gain / _alive(tracks, group, np.arange(tracks.num_frames)).sum()
    enough = mean >= tuning.min_better_llr
    nats = float(mean * np.sqrt(_alive(tracks, group, frames).sum())) if enough else 0.0
    wrong = _wrong(problem, solution, given, group) if nats >= tuning.decisive_llr else []
    doubts = [_doubt(tracks, solution, j, nats) for j in wrong]
    for j in group[(solution.identity[group] == NO_MATCH) & (len(doubts) == 0)]:
        own = float(solution.llr[j, given[j]])
        off = -float(own * np.sqrt(_alive(tracks, np.array([j]), frames).sum()))
        if own <= tuning.misplaced_llr and off >= tuning.decisive_llr:
            doubts.append(_doubt(tracks, solution, int(j), off))
    return doubts


def _alive(tracks: Trajectories, group: np.ndarray, frames: np.ndarray) -> Bool[np.ndarray, " frames"]:
    """Which of `frames` see a trajectory of the group."""
    alive = (tracks.start[group] <= frames[:, None]) & (frames[:, None] < tracks.stop[group])
    return np.asarray(alive.any(1))


def _wrong(problem: LabellingProblem, solution: Solution, given: np.ndarray, group: np.ndarray) -> list[int]:
    """Trajectories of a group whose own evidence is clear too.

    One that is to go without a label loses it to others of the group for a good part of its life. One that takes a
    label takes it from nobody who keeps it.
    """
    tracks, tuning, identity = problem.trajectories, problem.tuning, solution.identity
    named = group[identity[group] != NO_MATCH]
    own = solution.llr[named, identity[named]]
    old = np.where(given[named] != NO_MATCH, solution.llr[named, given[named]], tuning.accept_llr)
    named = named[(own >= tuning.accept_llr) & (own > old)]
    bare = group[identity[group] == NO_MATCH]
    taken = [j for j in bare if _share_taken(tracks, identity, given, j, named) > tuning.max_taken_share]
    wrong = {*named.tolist(), *map(int, taken)}
    robbed = {j: [k for k in group if given[k] == identity[j] and _common(tracks, j, k)] for j in named}
    return sorted(j for j in wrong if wrong.issuperset(map(int, robbed.get(j, []))))


def _share_taken(tracks: Trajectories, identity: np.ndarray, given: np.ndarray, j: int, others: np.ndarray) -> float:
    """The share of a trajectory's life in which others have the label that it was given."""
    takers = others[identity[others] == given[j]]
    return sum(_common(tracks, j, int(k)) for k in takers) / (tracks.stop[j] - tracks.start[j])


def _common(tracks: Trajectories, j: int, k: int) -> int:
    """Frames in which both are seen."""
    return max(0, int(min(tracks.stop[j], tracks.stop[k]) - max(tracks.start[j], tracks.start[k])))


def _doubt(tracks: Trajectories, solution: Solution, j: int, nats: float) -> Doubt:
    column = int(tracks.column[tracks.start[j], tracks.slot[j]])
    return Doubt(column, int(tracks.start[j]), int(tracks.stop[j]) - 1, int(solution.identity[j]), nats)


def _joined(doubts: list[Doubt], recording: Recording) -> list[Doubt]:
    """Doubts of one column that say the same and have no point between them made one, as sure as the less sure."""
    joined: list[Doubt] = []
    for d in doubts:
        last = joined[-1] if joined else None
        same = last is not None and (last.column, last.should_be) == (d.column, d.should_be)
        if last is not None and same and not recording.present[last.last + 1 : d.first, d.column].any():
            joined[-1] = Doubt(d.column, last.first, d.last, d.should_be, min(last.nats, d.nats))
        else:
            joined.append(d)
    return joined
