"""What was decided about each trajectory, as the page of a recording shows it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Int

from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import NO_MATCH
from dshpm_jax.report._doubts import doubt_of


@dataclass(frozen=True)
class Span:
    """A trajectory: the column and frames (both ends belong to it) in which it is, and what was decided about it.

    `reason` is in plain words, and says why its label is in doubt if that is so.
    """

    column: int
    first: int
    last: int
    confidence: float
    reason: str
    doubtful: bool = False


Owners = Int[np.ndarray, "frames columns"]


def spans_of(
    sidecar: Mapping[str, Any], place: Mapping[str, int], tracks: Trajectories, columns: tuple[int, int]
) -> tuple[tuple[Span, ...], tuple[Span, ...]]:
    """A span for each trajectory of the sidecar that has a label, and for each packed one that has none; the doubts.

    Arguments:
        place: the column of each label on the page.
        tracks: the unlabelled points, packed.
        columns: of the file, how many have a label and how many have none; on the page the former come first.
    """
    rows, names = sidecar["trajectories"], columns[0]
    given = [_span(place[row["label"]], row["frames"], row, sidecar) for row in rows if row["label"] is not None]
    owner = _owners(rows, tracks.num_frames, columns[1])
    rest = (
        []
        if owner is None
        else [
            _span(names + slot, (start, stop - 1), rows[owner[start, tracks.column[start, slot]]], sidecar)
            for start, stop, slot in zip(tracks.start.tolist(), tracks.stop.tolist(), tracks.slot.tolist(), strict=True)
            if owner[start, tracks.column[start, slot]] != NO_MATCH
        ]
    )
    withheld = [] if owner is None else _withheld(sidecar, tracks, owner, names)
    doubts = sorted([*(span for span in given if span.doubtful), *withheld], key=lambda span: (span.first, span.column))
    return (*given, *rest), tuple(doubts)


def _span(column: int, frames: Sequence[int], row: Mapping[str, Any], sidecar: Mapping[str, Any]) -> Span:
    doubt = doubt_of(row, sidecar)
    first, last = frames
    return Span(column, first, last, row["confidence"], doubt.words if doubt else row["reason"], doubt is not None)


def _withheld(sidecar: Mapping[str, Any], tracks: Trajectories, owner: Owners, names: int) -> Iterator[Span]:
    """A span for each trajectory without a label that is in doubt, where it begins on the page."""
    for number, row in enumerate(sidecar["trajectories"]):
        if row["label"] is None and doubt_of(row, sidecar):
            first = row["frames"][0]
            slots = np.flatnonzero(np.isin(tracks.column[first], np.flatnonzero(owner[first] == number)))
            if len(slots):
                yield _span(names + int(slots[0]), row["frames"], row, sidecar)


def _owners(rows: Sequence[Mapping[str, Any]], frames: int, columns: int) -> Owners | None:
    """The row that each unlabelled point belongs to.

    A labelled file has an unlabelled column for each source column that has such points, in the order of the source.
    """
    runs = [
        (row, *run)
        for row, entry in enumerate(rows)
        if entry["label"] is None
        for run in (entry.get("columns") or [[entry["column"], *entry["frames"]]])
    ]
    order = {column: k for k, column in enumerate(sorted({column for _, column, _, _ in runs}))}
    if len(order) != columns:
        return None
    owner = np.full((frames, columns), NO_MATCH)
    for row, column, first, last in runs:
        owner[first : last + 1, order[column]] = row
    return owner
