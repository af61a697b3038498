"""A labelling with other labels in some of its points: trajectories are cut where their label changes."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Int

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


class Effect(NamedTuple):
    """A run of points of one column whose label is another now.

    Attributes:
        column: of the recording's file.
        first, last: frames `first <= t < last`.
        was, now: the labels; None where there is none.
        confidence, reason: those of `was`.
    """

    column: int
    first: int
    last: int
    was: str | None
    now: str | None
    confidence: float
    reason: str


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


def difference(before: Labelling, after: Labelling) -> list[Effect]:
    """What changed, in the order of columns and frames; both pack the same points into the same slots."""
    was, now = labels_at(before), labels_at(after)
    frames, names = labelling_frames(before), (*before.model.markers, None)
    found = []
    for slot in np.flatnonzero((was != now).any(0)):
        tracks = before.trajectories
        column = tracks.column[:, slot]
        stamp = np.stack([was[:, slot], now[:, slot], column, tracks.index[:, slot]])
        differs = was[:, slot] != now[:, slot]
        edges = np.flatnonzero((stamp[:, 1:] != stamp[:, :-1]).any(0)) + 1
        for first, stop in zip([0, *edges], [*edges, frames], strict=True):
            if differs[first]:
                j = tracks.index[first, slot]
                place = before.recording.columns[column[first]], int(first), int(stop)
                labels = names[was[first, slot]], names[now[first, slot]]
                found.append(Effect(*place, *labels, float(before.confidence[j]), str(before.reason[j])))
    return sorted(found, key=lambda effect: effect[:3])


def after(labelling: Labelling, effects: Sequence[Effect], back: bool = False) -> Labelling:
    """The labelling after `effects`, or, `back`, before them."""
    tracks, number = labelling.trajectories, {name: k for k, name in enumerate(labelling.model.markers)}
    place = {column: k for k, column in enumerate(labelling.recording.columns)}
    note, verdicts = nothing_new(labelling), []
    for effect in effects:
        label = effect.was if back else effect.now
        some = slice(effect.first, effect.last)
        here = tracks.column[some] == place.get(effect.column, AS_IT_WAS)
        note[some][here & (tracks.index[some] != NO_MATCH)] = len(verdicts)
        sure = effect.confidence if back else 1.0
        reason = reason_of(effect.reason) if back else (Reason.MATCHED if label is not None else Reason.TAKEN)
        verdicts.append(Verdict(NO_MATCH if label is None else number.get(label, NO_MATCH), sure, reason))
    return rewritten(labelling, note, verdicts)


def labelling_frames(labelling: Labelling) -> int:
    return labelling.trajectories.num_frames


def reason_of(text: str) -> Reason:
    """The reason with this text; one that only another version knows counts as the plainest."""
    return Reason(text) if text in set(Reason) else Reason.MATCHED


def _could_be(labelling: Labelling) -> Int[np.ndarray, "trajectories 2"]:
    if labelling.could_be is None:
        return np.full((len(labelling.trajectories), 2), NO_MATCH, np.int32)
    return labelling.could_be.copy()
