"""Audits labels that are there: where others explain the recording decidedly better, and where none fits."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Int
from scipy.sparse.csgraph import connected_components

from dshpm_jax._control.dividing import divide
from dshpm_jax._control.evidence import ACCEPT, FrameEvidence, frame_evidence, labels_in, sample_frames
from dshpm_jax._control.full import full
from dshpm_jax._control.moves import Move, judge_moves
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State, improve, settle
from dshpm_jax._control.slips import LEAP, leaps, slips
from dshpm_jax._model import SubjectModel
from dshpm_jax._pretracking import unbroken_columns
from dshpm_jax._recording import Recording
from dshpm_jax._requests import Control
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import Trajectories, from_columns
from dshpm_jax._types import NO_MATCH

BREAK = 5.0
"""Nats by which the evidence for a column's own label changes within a frame where its point becomes another's."""

DECISIVE = 8.0
"""Nats by which other labels must beat those of the file in a single frame. Frames of one life repeat one another: the
mean over `n` of them counts `sqrt(n)` times."""

LEAST = 2.0
"""Nats a frame that it takes however many frames there are."""

TAKEN = 0.25
"""Share of its life in which another point is the marker, from which on a label is wrong where it is."""

NOWHERE = -6.0
"""Evidence down to which a label is not called wrong if no other point is the marker."""


@dataclass(frozen=True, eq=False)
class Doubt:
    """A column whose label is wrong in some frames.

    Attributes:
        column: of the recording.
        first, last: frames, both belong to it.
        should_be: the marker that the point is, `NO_MATCH` if it is none, or off its place.
        nats: how decisive that is; see `DECISIVE` and `SLIPS`.
    """

    column: int
    first: int
    last: int
    should_be: int
    nats: float


def audit(recording: Recording, model: SubjectModel, settings: Settings) -> Control:
    """Every `Doubt` about the labels of `recording`, in the order of columns and frames.

    The recording is labelled as if it had no names, and once more from the names that it has; the better of the two by
    the objective, which needs no truth, is held against the file, difference by difference.
    """
    place = {name: k for k, name in enumerate(model.markers)}
    names = np.array([place.get(label, NO_MATCH) for label in recording.labels])
    tracks = yield from _tracks(recording, model, settings, names)
    scene = Scene(tracks, model, settings)
    given = names[_columns(tracks)]
    frames = sample_frames(scene)
    best, _ = yield from full(scene)
    own = yield from settle(scene, given, frames)
    own = yield from improve(scene, own, frames)
    scene, state = yield from divide(scene, max((own, best), key=lambda s: s.worth))
    tracks, frames = scene.trajectories, sample_frames(scene)
    given = names[_columns(tracks)]
    groups = _groups(tracks, given, state.identity)
    back = [Move(group, given[group], 0.0) for group in groups]
    loss = (yield from judge_moves(scene, state.identity, back, frames, state.frames)) if back else []
    state = replace(state, identity=_without_smooth_changes(recording, tracks, given, state.identity))
    found = [d for group, lost in zip(groups, loss) for d in _doubts(tracks, state, given, group, -lost, frames)]
    sound = np.where(state.identity == given, given, NO_MATCH)
    own = yield from _own_evidence(scene, state.identity, recording.points.shape[:2])
    own[tracks.by_column(sound, own.shape[1]) == NO_MATCH] = np.nan
    off = slips(own, recording.points, recording.rate)
    found += [Doubt(column, first, last, NO_MATCH, fall) for column, first, last, fall in off]
    return _joined(sorted(found, key=lambda d: (d.column, d.first)), recording)


def _columns(tracks: Trajectories) -> Int[np.ndarray, " trajectories"]:
    return tracks.column[tracks.start, tracks.slot]


def _tracks(recording: Recording, model: SubjectModel, settings: Settings, names: np.ndarray) -> Control:
    """The columns, cut at gaps and jumps and where the evidence for their own labels breaks."""
    points = recording.points
    links = unbroken_columns(points, recording.rate)
    tracks = from_columns(points, recording.rate, links)
    own = yield from _own_evidence(Scene(tracks, model, settings), names[_columns(tracks)], points.shape[:2])
    with np.errstate(invalid="ignore"):
        broken = np.abs(np.diff(own, axis=0)) > BREAK
    links[:-1][broken] = NO_MATCH
    return from_columns(points, recording.rate, links)


def _own_evidence(scene: Scene, identity: np.ndarray, shape: tuple[int, int]) -> Control:
    """Evidence for the label of every labelled point of the recording, NaN for the others."""
    tracks = scene.trajectories
    frames = np.arange(tracks.num_frames)
    found: FrameEvidence = yield from frame_evidence(scene, frames, labels_in(scene, identity, frames))
    frame, slot = np.nonzero(found.named != NO_MATCH)
    own = np.full(shape, np.nan)
    own[frame, tracks.column[frame, slot]] = found.evidence[frame, slot, found.named[frame, slot]]
    return own


def _without_smooth_changes(
    recording: Recording, tracks: Trajectories, given: np.ndarray, found: np.ndarray
) -> Int[np.ndarray, " trajectories"]:
    """`found` with the label given wherever a column would change its label without a leap of its point."""
    # Evidence also breaks where neighbours come and go, but a point that goes on smoothly is no other than before.
    smooth = leaps(recording.points) <= LEAP
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
    tracks: Trajectories, state: State, given: np.ndarray, group: np.ndarray, gain: float, frames: np.ndarray
) -> list[Doubt]:
    """What is wrong in a group, if that is decisive: where the other labels are better, or the one there is nowhere.

    `gain` is by how much the labels found are better than those of the file (nat frames).
    """
    mean = gain / _alive(tracks, group, np.arange(tracks.num_frames)).sum()
    nats = float(mean * np.sqrt(_alive(tracks, group, frames).sum())) if mean >= LEAST else 0.0
    doubts = [_doubt(tracks, state, j, nats) for j in _wrong(tracks, state, given, group)] if nats >= DECISIVE else []
    for j in group[(state.identity[group] == NO_MATCH) & (len(doubts) == 0)]:
        off = -float(state.evidence[j, given[j]] * np.sqrt(_alive(tracks, np.array([j]), frames).sum()))
        if state.evidence[j, given[j]] <= NOWHERE and off >= DECISIVE:
            doubts.append(_doubt(tracks, state, int(j), off))
    return doubts


def _alive(tracks: Trajectories, group: np.ndarray, frames: np.ndarray) -> Bool[np.ndarray, " frames"]:
    """Which of `frames` see a trajectory of the group."""
    alive = (tracks.start[group] <= frames[:, None]) & (frames[:, None] < tracks.stop[group])
    return np.asarray(alive.any(1))


def _wrong(tracks: Trajectories, state: State, given: np.ndarray, group: np.ndarray) -> list[int]:
    """Trajectories of a group whose own evidence is clear too.

    One that is to go without a label loses it to others of the group for a good part of its life. One that takes a
    label takes it from nobody who keeps it.
    """
    named = group[state.identity[group] != NO_MATCH]
    own = state.evidence[named, state.identity[named]]
    old = np.where(given[named] != NO_MATCH, state.evidence[named, given[named]], ACCEPT)
    named = named[(own >= ACCEPT) & (own > old)]
    bare = [j for j in group[state.identity[group] == NO_MATCH] if _share_taken(tracks, state, given, j, named) > TAKEN]
    wrong = {*named.tolist(), *map(int, bare)}
    robbed = {j: [k for k in group if given[k] == state.identity[j] and _common(tracks, j, k)] for j in named}
    return sorted(j for j in wrong if wrong.issuperset(map(int, robbed.get(j, []))))


def _share_taken(tracks: Trajectories, state: State, given: np.ndarray, j: int, others: np.ndarray) -> float:
    takers = others[state.identity[others] == given[j]]
    return sum(_common(tracks, j, int(k)) for k in takers) / (tracks.stop[j] - tracks.start[j])


def _common(tracks: Trajectories, j: int, k: int) -> int:
    """Frames in which both are seen."""
    return max(0, int(min(tracks.stop[j], tracks.stop[k]) - max(tracks.start[j], tracks.start[k])))


def _doubt(tracks: Trajectories, state: State, j: int, nats: float) -> Doubt:
    column = int(tracks.column[tracks.start[j], tracks.slot[j]])
    return Doubt(column, int(tracks.start[j]), int(tracks.stop[j]) - 1, int(state.identity[j]), nats)


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
