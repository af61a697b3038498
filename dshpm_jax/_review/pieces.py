"""A labelling with other labels in some of its points: trajectories are cut where their label changes."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._labelling import Labelling, Reason
from dshpm_jax._types import NO_MATCH

AS_IT_WAS = -1
"""In `rewritten`: nothing new about this point."""

NONE = (NO_MATCH, NO_MATCH)

Place = tuple[int, int]
"""A column of the recording's file and a frame."""


class Verdict(NamedTuple):
    """What is decided about some points: see the fields of `Labelling`."""

    identity: int
    confidence: float
    reason: Reason
    could_be: tuple[int, int] = NONE


class Said(NamedTuple):
    """What was said of some points: the label (None: none), how sure it is, and why, as sidecars have it."""

    label: str | None
    confidence: float
    reason: str


class Effect(NamedTuple):
    """A run of points of one column of which something else is said now.

    Attributes:
        column: of the recording's file.
        first, last: frames `first <= t < last`.
    """

    column: int
    first: int
    last: int
    was: Said
    now: Said

    @classmethod
    def of(cls, plain: Sequence[Any]) -> "Effect":
        """From what JSON made of it."""
        column, first, last, was, now = plain
        return cls(int(column), int(first), int(last), Said(*was), Said(*now))


def rewritten(labelling: Labelling, note: Int[np.ndarray, "frames slots"], verdicts: Sequence[Verdict]) -> Labelling:
    """The labelling with a new verdict for some points.

    Arguments:
        note: for each point (as `Trajectories` packs them) the number of its verdict, or `AS_IT_WAS`.
    """
    tracks = labelling.trajectories
    index = tracks.index
    same = (index[1:] == index[:-1]) & (index[1:] != NO_MATCH)
    frame, slot = np.nonzero(same & (note[1:] != note[:-1]))
    cut, source = tracks.cut(index[frame + 1, slot], frame + 1)
    new = note[cut.start, cut.slot]
    touched = np.flatnonzero(new != AS_IT_WAS)
    said = [verdicts[k] for k in new[touched]]
    identity, confidence = labelling.identity[source].astype(np.int32), labelling.confidence[source].astype(float)
    could_be = _could_be(labelling)[source]
    reason = [labelling.reason[k] for k in source]
    for j, verdict in zip(touched, said, strict=True):
        identity[j], confidence[j], reason[j], could_be[j] = verdict
    return replace(
        labelling,
        trajectories=cut,
        identity=identity,
        confidence=confidence,
        reason=tuple(reason),
        could_be=could_be,
    )


def adopted(mine: Labelling, other: Labelling) -> Labelling:
    """`mine` with the labels of `other`, which may have cut the same points into other trajectories."""
    columns = mine.recording.points.shape[1]
    theirs = other.trajectories.by_column(np.arange(len(other.trajectories)), columns)
    tracks, could_be = mine.trajectories, _could_be(other)
    frame, slot = np.nonzero(tracks.index != NO_MATCH)
    note = np.full(tracks.index.shape, AS_IT_WAS)
    note[frame, slot] = theirs[frame, tracks.column[frame, slot]]
    verdicts = [
        Verdict(int(m), float(c), r, (int(one), int(two)))
        for m, c, r, (one, two) in zip(other.identity, other.confidence, other.reason, could_be, strict=True)
    ]
    return replace(rewritten(mine, note, verdicts), stats=other.stats)


def nothing_new(labelling: Labelling) -> Int[np.ndarray, "frames slots"]:
    """A `note` for `rewritten` to begin with."""
    return np.full(labelling.trajectories.index.shape, AS_IT_WAS)


def labels_at(labelling: Labelling) -> Int[np.ndarray, "frames slots"]:
    """The label of each point, `NO_MATCH` where it has none or there is no point."""
    index = labelling.trajectories.index
    return np.where(index != NO_MATCH, labelling.identity[np.maximum(index, 0)], NO_MATCH)


def difference(
    before: Labelling, later: Labelling, own: Bool[np.ndarray, "frames slots"] | None = None
) -> list[Effect]:
    """What changed, in the order of columns and frames.

    Arguments:
        before, later: the same points, packed into the same slots.
        own: points of which it counts as well if only the confidence changed.
    """
    was, now = labels_at(before), labels_at(later)
    differs = was != now
    if own is not None:
        differs |= own & (_sure_at(before) != _sure_at(later))
    return sorted(
        effect for slot in np.flatnonzero(differs.any(0)).tolist() for effect in _in_slot(before, later, differs, slot)
    )


def _in_slot(before: Labelling, later: Labelling, differs: np.ndarray, slot: int) -> Iterator[Effect]:
    index, then = before.trajectories.index[:, slot], later.trajectories.index[:, slot]
    column = before.trajectories.column[:, slot]
    stamp = np.stack([differs[:, slot], column, index, then])
    edges = np.flatnonzero((stamp[:, 1:] != stamp[:, :-1]).any(0)) + 1
    for first, last in zip([0, *edges.tolist()], [*edges.tolist(), len(index)], strict=True):
        if differs[first, slot]:
            place = before.recording.columns[column[first]], first, last
            yield Effect(*place, _said(before, index[first]), _said(later, then[first]))


def after(labelling: Labelling, effects: Sequence[Effect], back: bool = False) -> Labelling:
    """The labelling after `effects`, or, `back`, before them."""
    tracks, number = labelling.trajectories, {name: k for k, name in enumerate(labelling.model.markers)}
    place = {column: k for k, column in enumerate(labelling.recording.columns)}
    note, verdicts = nothing_new(labelling), []
    for effect in effects:
        label, sure, reason = effect.was if back else effect.now
        some = slice(effect.first, effect.last)
        here = tracks.column[some] == place.get(effect.column, AS_IT_WAS - 1)
        note[some][here] = len(verdicts)
        verdicts.append(Verdict(NO_MATCH if label is None else number.get(label, NO_MATCH), sure, reason_of(reason)))
    return rewritten(labelling, note, verdicts)


def cuts_between(before: Labelling, later: Labelling) -> list[Place]:
    """Where trajectories that went on before are cut now: the column, and the first frame behind the cut."""
    tracks, index = later.trajectories, before.trajectories.index
    began = np.flatnonzero(tracks.start > 0)
    start, slot = tracks.start[began], tracks.slot[began]
    new = (index[start, slot] == index[start - 1, slot]) & (index[start, slot] != NO_MATCH)
    columns = tracks.column[start[new], slot[new]]
    return [(before.recording.columns[c], int(t)) for c, t in zip(columns, start[new], strict=True)]


def joined_again(labelling: Labelling, places: Iterable[Place]) -> Labelling:
    """Trajectories that were cut at these places as one again, as far as the parts have one label."""
    tracks, joins = labelling.trajectories, []
    for column, frame in places:
        here = np.flatnonzero(tracks.column[frame] == labelling.recording.columns.index(column))
        left, right = (int(k) for k in tracks.index[frame - 1 : frame + 1, here[0]]) if len(here) else (0, 0)
        if left != right and NO_MATCH not in (left, right) and labelling.identity[left] == labelling.identity[right]:
            joins.append((left, right))
    into = np.arange(len(tracks))
    stop = tracks.stop.copy()
    for left, right in sorted(joins, reverse=True):  # from the last part on, so that each takes over all behind it
        into[into == right] = left
        stop[left] = stop[right]
    keep = into == np.arange(len(tracks))
    number = (np.cumsum(keep) - 1)[into]
    index = np.where(tracks.index != NO_MATCH, number[np.maximum(tracks.index, 0)], NO_MATCH).astype(tracks.index.dtype)
    lives = {"slot": tracks.slot[keep], "start": tracks.start[keep], "stop": stop[keep]}
    return replace(
        labelling,
        trajectories=replace(tracks, index=index, **lives),
        identity=labelling.identity[keep],
        confidence=labelling.confidence[keep],
        reason=tuple(r for r, k in zip(labelling.reason, keep, strict=True) if k),
        could_be=_could_be(labelling)[keep],
    )


def cut_again(labelling: Labelling, places: Iterable[Place]) -> Labelling:
    """The trajectories cut at these places, unless they are already."""
    tracks = labelling.trajectories
    which, frames = [], []
    for column, frame in places:
        here = np.flatnonzero(tracks.column[frame] == labelling.recording.columns.index(column))
        trajectory = int(tracks.index[frame, here[0]]) if len(here) else NO_MATCH
        if trajectory != NO_MATCH and tracks.start[trajectory] < frame:
            which.append(trajectory)
            frames.append(frame)
    if not which:
        return labelling
    cut, source = tracks.cut(np.array(which), np.array(frames))
    return replace(
        labelling,
        trajectories=cut,
        identity=labelling.identity[source],
        confidence=labelling.confidence[source],
        reason=tuple(labelling.reason[k] for k in source),
        could_be=_could_be(labelling)[source],
    )


def _said(labelling: Labelling, trajectory: int) -> Said:
    identity = labelling.identity[trajectory]
    label = None if identity == NO_MATCH else labelling.model.markers[identity]
    return Said(label, round(float(labelling.confidence[trajectory]), 4), str(labelling.reason[trajectory]))


def _sure_at(labelling: Labelling) -> Float[np.ndarray, "frames slots"]:
    index = labelling.trajectories.index
    return np.where(index != NO_MATCH, labelling.confidence[np.maximum(index, 0)], 0.0)


def reason_of(text: str) -> Reason:
    """The reason with this text; one that only another version knows counts as the plainest."""
    return Reason(text) if text in set(Reason) else Reason.MATCHED


def _could_be(labelling: Labelling) -> Int[np.ndarray, "trajectories 2"]:
    if labelling.could_be is None:
        return np.full((len(labelling.trajectories), 2), NO_MATCH, np.int32)
    return labelling.could_be.copy()
