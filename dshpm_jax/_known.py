"""Labels that are given with a recording, as a person or its file says them."""

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from dshpm_jax._geometry import is_seen
from dshpm_jax._recording import Recording, no_such_name
from dshpm_jax._types import NO_MATCH, UNKNOWN

END = sys.maxsize  # of a span that ends with its recording


@dataclass(frozen=True)
class KnownLabel:
    """Some points of a recording of which the label is known: a column, over a span of frames or all of it.

    Attributes:
        column: of the source file, from 0, as `Recording.columns` counts them.
        first, last: the span, frames `first <= t < last` from 0; to the end of the recording where `last` is None.
        label: the marker's name as the labelling calls it (with the subject's before it where there are several), or
            None where the points are no marker.

    Raises:
        ValueError: the column or the span cannot be.
    """

    column: int
    first: int = 0
    last: int | None = None
    label: str | None = None

    def __post_init__(self):
        if self.column < 0 or self.first < 0 or (self.last is not None and self.last <= self.first):
            raise ValueError(f"{self}: columns and frames count from 0, and a span ends after its first frame")

    def __str__(self) -> str:
        until = "the end" if self.last is None else f"{self.last - 1}"
        return f"column {self.column}, frames {self.first} to {until}: {self.label or 'no marker'}"


def latest(known: Iterable[KnownLabel]) -> tuple[KnownLabel, ...]:
    """The known labels less what later ones say otherwise, by column and frame.

    Of one point the last label counts, and of one label in one frame the last column.
    """
    spans: list[KnownLabel] = []
    for new in known:
        spans = [*without(spans, new), new]
    return tuple(sorted(spans, key=lambda one: (one.column, one.first)))


def without(known: Sequence[KnownLabel], new: KnownLabel) -> list[KnownLabel]:
    """What is left of known labels where another says otherwise of the same points, or of the same label."""
    meet = (one.column == new.column or (one.label is not None and one.label == new.label) for one in known)
    return [part for one, both in zip(known, meet) for part in (_outside(one, new) if both else [one])]


def _outside(old: KnownLabel, new: KnownLabel) -> list[KnownLabel]:
    """What is left of a span without the frames of another."""
    ends = [END if one.last is None else one.last for one in (old, new)]
    parts = (old.first, min(ends[0], new.first)), (max(old.first, ends[1]), ends[0])
    return [KnownLabel(old.column, a, None if b == END else b, old.label) for a, b in parts if a < b]


def names_known(
    recording: Recording, markers: Sequence[str], first: int = 0, last: int | None = None
) -> tuple[KnownLabel, ...]:
    """What the names of the columns say, as known labels: those of markers, in frames `first <= t < last`."""
    return tuple(
        KnownLabel(column, first, last, label)
        for column, label in zip(recording.columns, recording.labels)
        if label in markers
    )


def known_points(
    recording: Recording, markers: Sequence[str], known: Sequence[KnownLabel]
) -> Int[np.ndarray, "frames points"]:
    """For each point the marker that it is known to be, `NO_MATCH` where it is known to be none, else `UNKNOWN`.

    Raises:
        ValueError: a label is no marker, a span or a column is not in the recording, or two known labels contradict
            each other: one point with two labels, or one label on two points of a frame.
    """
    number = {name: k for k, name in enumerate(markers)}
    place = {column: k for k, column in enumerate(recording.columns)}
    columns = sorted({one.column for one in known})
    _check_spans(known, number, recording, place)
    within = {column: k for k, column in enumerate(columns)}  # a recording may have thousands of columns
    points = np.full((recording.num_frames, len(columns)), UNKNOWN, np.int32)
    said_by = np.full(points.shape, NO_MATCH, np.int32)  # which of `known`
    for k, one in enumerate(known):
        span = slice(one.first, one.last), within[one.column]
        label = NO_MATCH if one.label is None else number[one.label]
        other = np.flatnonzero((points[span] != UNKNOWN) & (points[span] != label))
        if len(other):
            _refuse(known[int(said_by[span][other[0]])], one, "give one point two labels")
        points[span], said_by[span] = label, k
    there = [place[column] for column in columns]
    points[~is_seen(recording.points[:, there])] = UNKNOWN
    _refuse_twice(points, said_by, known)
    found = np.full(recording.points.shape[:2], UNKNOWN, np.int32)
    found[:, there] = points
    return found


def _check_spans(
    known: Sequence[KnownLabel], number: Mapping[str, int], recording: Recording, place: Mapping[int, int]
) -> None:
    """Refuses labels that are no markers, and points that are not in the recording."""
    for one in known:
        if one.label is not None and one.label not in number:
            raise ValueError(f"{one}: {no_such_name(one.label, list(number), 'marker of the model')}")
        if one.column not in place or max(one.first + 1, one.last or 0) > recording.num_frames:
            size = f"{recording.num_frames} frames, and {len(place)} columns up to {max(place)}"
            raise ValueError(f"{one}: the recording has {size}; a known label has to be of one of these")


def points_of(recording: Recording, known: Iterable[KnownLabel]) -> Bool[np.ndarray, "frames points"]:
    """The points that known labels are of, seen or not."""
    place = {column: k for k, column in enumerate(recording.columns)}
    found = np.zeros(recording.points.shape[:2], bool)
    for one in known:
        found[one.first : one.last, place[one.column]] = True
    return found


def runs(
    points: Int[np.ndarray, "frames points"], apart: Int[np.ndarray, "frames points"] | None = None
) -> Iterator[tuple[int, int, int, int]]:
    """The unbroken runs of what is known of points: column, first frame, the frame after the last, label.

    Arguments:
        apart: runs also end where this changes.
    """
    other = points if apart is None else apart
    for column in np.flatnonzero((points != UNKNOWN).any(0)).tolist():
        changes = (np.diff(points[:, column]) != 0) | (np.diff(other[:, column]) != 0)
        edges = [0, *(np.flatnonzero(changes) + 1).tolist(), len(points)]
        for first, last in zip(edges, edges[1:]):
            if points[first, column] != UNKNOWN:
                yield column, first, last, int(points[first, column])


def _refuse_twice(points: np.ndarray, said_by: np.ndarray, known: Sequence[KnownLabel]) -> None:
    """Refuses a label on two points of one frame."""
    frame, column = np.nonzero(points >= 0)
    order = np.lexsort((points[frame, column], frame))
    frame, column = frame[order], column[order]
    label = points[frame, column]
    twice = np.flatnonzero((np.diff(frame) == 0) & (np.diff(label) == 0))
    if len(twice):
        one, other = sorted(int(said_by[frame[k], column[k]]) for k in (twice[0], twice[0] + 1))
        _refuse(known[one], known[other], f"are one marker on two points of frame {frame[twice[0]]}")


def _refuse(one: KnownLabel, other: KnownLabel, why: str) -> None:
    raise ValueError(f"known labels contradict each other: {one}; {other}: they {why}; leave one of them out")
