"""What the page of a recording shows: points in columns, what they are called, and how sure that is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from dshpm_jax._hierarchy import depth_first
from dshpm_jax._model import Segment
from dshpm_jax._recording import Recording
from dshpm_jax._trajectories import from_columns
from dshpm_jax.io import ReadError
from dshpm_jax.report._doubts import troubles_of
from dshpm_jax.report._links import Part, links_of
from dshpm_jax.report._spans import Span, spans_of


@dataclass(frozen=True, eq=False)
class Film:
    """A recording as its page shows it.

    Attributes:
        names: the labels, one for each of the first columns; the others hold points without a label.
        points: places (mm), NaN where there is none; columns of unlabelled points are shared by those that follow one
            another.
        rate: frames a second (Hz).
        parts: the segments, neighbours in the hierarchy one after the other; none if they are not known.
        links: pairs of columns to draw a stick between, and the part it belongs to (-1: none).
        spans: what was decided about each trajectory, as far as that is known.
        doubts: those of labels in doubt, one a trajectory, in the order of frames.
        troubles: what is doubtful about all labels, a sentence each.
        notes: what was doubtful about the recording's file, a sentence each.
    """

    names: tuple[str, ...]
    points: Float[np.ndarray, "frames columns 3"]
    rate: float
    parts: tuple[Part, ...]
    links: tuple[tuple[int, int, int], ...]
    spans: tuple[Span, ...]
    doubts: tuple[Span, ...]
    troubles: tuple[str, ...]
    notes: tuple[str, ...]


def make_film(
    recording: Recording, sidecar: Mapping[str, Any] | None = None, parts: Mapping[str, Sequence[str]] | None = None
) -> Film:
    """The film of a labelled recording.

    Arguments:
        recording: labelled; columns without a name hold unlabelled points.
        sidecar: what was decided about its trajectories, if known; `ReadError` if it is about another recording.
        parts: names of segments and of their markers, in the order of the hierarchy; by default those of the sidecar.

    Raises:
        ValueError: the recording has no points.
    """
    if not recording.present.any():
        raise ValueError("no point is seen in any frame; there is nothing to show")
    named = np.flatnonzero(recording.labelled)
    place = {recording.labels[c]: k for k, c in enumerate(named)}
    names = list(place) if len(place) == len(named) else [recording.labels[c] for c in named]
    if sidecar is not None:
        place = _places_of(sidecar, recording, place)
    rest = recording.points[:, ~recording.labelled]
    tracks = from_columns(rest, recording.rate)
    points = np.concatenate([recording.points[:, named], tracks.points], axis=1)
    parts = _parts_of(sidecar) if parts is None and sidecar is not None else parts or {}
    found = tuple(
        Part(name, columns)
        for name, markers in parts.items()
        if (columns := tuple(place[marker] for marker in markers if marker in place))
    )
    return Film(
        tuple(names),
        points,
        recording.rate,
        found,
        tuple(links_of(points[:, : len(named)], found, names)),
        *(spans_of(sidecar, place, tracks, (len(named), rest.shape[1])) if sidecar is not None else ((), ())),
        tuple(troubles_of(sidecar)) if sidecar is not None else (),
        tuple(recording.notes if sidecar is None else sidecar.get("notes", ())),
    )


def parts_of_model(segments: Sequence[Segment], markers: Sequence[str]) -> dict[str, list[str]]:
    """The segments of a model as `make_film` takes them."""
    return {segments[s].name: [markers[m] for m in segments[s].markers] for s in depth_first(segments)}


def _parts_of(sidecar: Mapping[str, Any]) -> dict[str, list[str]]:
    return {segment["name"]: segment["markers"] for segment in sidecar.get("segments", ())}


def _places_of(sidecar: Mapping[str, Any], recording: Recording, place: Mapping[str, int]) -> dict[str, int]:
    """The column of each label of the sidecar, which may carry the name of a subject that the file's reader drops."""
    bare = {marker: place.get(marker, place.get(marker.rsplit(":", 1)[-1])) for marker in sidecar["markers"]}
    given = {row["label"] for row in sidecar["trajectories"]} - {None}
    if sidecar["frames"] != recording.num_frames or any(bare.get(label) is None for label in given):
        path = recording.source or "the recording"
        remedy = "move the sidecar away, or label the recording again"
        raise ReadError(path, "the sidecar beside it is about another recording", remedy)
    return {marker: column for marker, column in bare.items() if column is not None}
