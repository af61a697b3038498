"""What a person can do to labels: each gives the labelling after it, and what is known from then on."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool

from dshpm_jax._known import KnownLabel
from dshpm_jax._labelling import Labelling, Reason
from dshpm_jax._review.pieces import Verdict, labels_at, nothing_new, rewritten
from dshpm_jax._types import NO_MATCH


class Edit(NamedTuple):
    """What a person did.

    Attributes:
        labelling: with what was said, and without labels that clash with it; nothing else is solved anew.
        known: what was said.
    """

    labelling: Labelling
    known: tuple[KnownLabel, ...]


class Span(NamedTuple):
    """Frames `first <= t < last`."""

    first: int
    last: int


def assign(labelling: Labelling, trajectory: int, span: Span, marker: int) -> Edit:
    """A trajectory is `marker` (`NO_MATCH`: none) over a span; others that have that label there lose it.

    Raises:
        ValueError: the trajectory is not seen in the span.
    """
    return say(labelling, _within(labelling, trajectory, span), marker)


def say(labelling: Labelling, cells: Bool[np.ndarray, "frames slots"], marker: int) -> Edit:
    """Some points are `marker` (`NO_MATCH`: none); others that have that label in these frames lose it."""
    note, verdicts = nothing_new(labelling), [_said(marker), Verdict(NO_MATCH, 0.5, Reason.TAKEN)]
    if marker != NO_MATCH:
        note[np.equal(labels_at(labelling), marker) & cells.any(1, keepdims=True)] = 1
    note[cells] = 0
    return Edit(rewritten(labelling, note, verdicts), _known(labelling, cells, marker))


def exchange(labelling: Labelling, one: int, other: int, span: Span) -> Edit:
    """What is called the one marker is the other over a span, and the other way round.

    Raises:
        ValueError: neither is seen in the span, or both are the same.
    """
    if one == other:
        raise ValueError("two labels are exchanged, not one with itself")
    labels, inside = labels_at(labelling), _inside(labelling, span)
    note, known = nothing_new(labelling), []
    for k, (now, then) in enumerate([(one, other), (other, one)]):
        cells = (labels == now) & inside
        note[cells] = k
        known += _known(labelling, cells, then)
    if not known:
        raise ValueError("neither label is there in these frames")
    return Edit(rewritten(labelling, note, [_said(other), _said(one)]), tuple(known))


def merge(labelling: Labelling, trajectory: int, with_: int) -> Edit:
    """Two trajectories are one marker: the label of the one that has one goes to the other, the first's if both have.

    Raises:
        ValueError: they are seen at the same time, or neither has a label.
    """
    tracks = labelling.trajectories
    if tracks.start[trajectory] < tracks.stop[with_] and tracks.start[with_] < tracks.stop[trajectory]:
        raise ValueError("both are seen at the same time, so they are two markers")
    source, target = (trajectory, with_) if labelling.identity[trajectory] != NO_MATCH else (with_, trajectory)
    if labelling.identity[source] == NO_MATCH:
        raise ValueError("neither of the two has a label yet; give one of them a label first")
    marker = int(labelling.identity[source])
    kept = _within(labelling, source, whole(labelling, source))
    edit = assign(labelling, target, whole(labelling, target), marker)
    return edit._replace(known=(*_known(labelling, kept, marker), *edit.known))


def split(labelling: Labelling, trajectory: int, frame: int) -> Labelling:
    """The trajectory cut before a frame, so that its parts can have labels of their own.

    Raises:
        ValueError: the frame is not inside it.
    """
    tracks = labelling.trajectories
    if not tracks.start[trajectory] < frame < tracks.stop[trajectory]:
        raise ValueError("go to a frame inside the trajectory, behind its first one")
    note = nothing_new(labelling)
    note[frame : tracks.stop[trajectory], tracks.slot[trajectory]] = 0
    could_be = NO_MATCH, NO_MATCH
    if labelling.could_be is not None:
        could_be = (int(labelling.could_be[trajectory, 0]), int(labelling.could_be[trajectory, 1]))
    kept = float(labelling.confidence[trajectory]), labelling.reason[trajectory], could_be
    return rewritten(labelling, note, [Verdict(int(labelling.identity[trajectory]), *kept)])


def whole(labelling: Labelling, trajectory: int) -> Span:
    """The life of a trajectory."""
    tracks = labelling.trajectories
    return Span(int(tracks.start[trajectory]), int(tracks.stop[trajectory]))


def _said(marker: int) -> Verdict:
    return Verdict(marker, 1.0, Reason.KNOWN)


def _within(labelling: Labelling, trajectory: int, span: Span) -> Bool[np.ndarray, "frames slots"]:
    cells = (labelling.trajectories.index == trajectory) & _inside(labelling, span)
    if not cells.any():
        raise ValueError("the trajectory is not seen in these frames")
    return cells


def _inside(labelling: Labelling, span: Span) -> Bool[np.ndarray, "frames 1"]:
    frames = np.arange(labelling.trajectories.num_frames)
    return ((frames >= span.first) & (frames < span.last))[:, None]


def _known(labelling: Labelling, cells: Bool[np.ndarray, "frames slots"], marker: int) -> tuple[KnownLabel, ...]:
    """What is known when these points are `marker`: a column and a run of frames each."""
    name = None if marker == NO_MATCH else labelling.model.markers[marker]
    found, columns = [], labelling.recording.columns
    for slot in np.flatnonzero(cells.any(0)):
        frames = np.flatnonzero(cells[:, slot])
        column = labelling.trajectories.column[frames, slot]
        edges = np.flatnonzero((np.diff(frames) != 1) | (np.diff(column) != 0)) + 1
        for first, stop in zip([0, *edges], [*edges, len(frames)], strict=True):
            found.append(KnownLabel(columns[column[first]], int(frames[first]), int(frames[stop - 1]) + 1, name))
    return tuple(found)
