"""A labelling with other labels in some of its points: trajectories are cut where their label changes."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._labelling import Labelling, Reason
from dshpm_jax._types import NO_MATCH

AS_IT_WAS = -1
"""In `rewritten`: nothing new about this point."""

NONE = (NO_MATCH, NO_MATCH)


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
