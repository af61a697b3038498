"""A result as it was written, opened again: its recording, its model, and what was decided about each trajectory."""

from collections.abc import Collection, Mapping
from dataclasses import fields
from typing import Any

import numpy as np
from jaxtyping import Int

from dshpm_jax._labelling import Labelling
from dshpm_jax._model import Segment, SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._review.pieces import Place, reason_of
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import Trajectories, from_columns
from dshpm_jax._types import NO_MATCH, NO_PARENT


def labelling_of(
    sidecar: Mapping[str, Any], recording: Recording, model: SubjectModel, cuts: Collection[Place] = ()
) -> Labelling:
    """The labelling that a sidecar was written of.

    Arguments:
        recording: the one that was labelled.
        model: with the markers of the sidecar.
        cuts: where a person's corrections cut trajectories. The parts are packed side by side, so that an undone cut
            can be mended.

    Raises:
        ValueError: the sidecar is about other points.
    """
    rows = sidecar["trajectories"]
    tracks = from_columns(recording.points, recording.rate, _links(rows, recording, set(cuts)))
    tracks = _cut(tracks, {_begin(row) for row in rows} & set(cuts), recording)
    row_of = {_begin(row): row for row in rows}
    columns = [recording.columns[c] for c in tracks.column[tracks.start, tracks.slot]]
    try:
        found = [row_of[column, int(start)] for column, start in zip(columns, tracks.start, strict=True)]
    except KeyError:
        raise ValueError("what is written beside it is about other points; label it again") from None
    number = {None: NO_MATCH, **{name: k for k, name in enumerate(model.markers)}}
    others = [[number.get(name, NO_MATCH) for name in row.get("could_be", ())] for row in found]
    return Labelling(
        recording,
        model,
        tracks,
        np.array([number.get(row["label"], NO_MATCH) for row in found], np.int32),
        np.array([row["confidence"] for row in found], float),
        tuple(reason_of(row["reason"]) for row in found),
        dict(sidecar.get("stats", {})),
        np.array([[*some, NO_MATCH, NO_MATCH][:2] for some in others], np.int32).reshape(-1, 2),
    )


def settings_of(sidecar: Mapping[str, Any]) -> Settings:
    """The settings that a result was made with; what this version does not know is left out."""
    known = {field.name for field in fields(Settings)}
    return Settings(**{name: value for name, value in sidecar.get("settings", {}).items() if name in known})


def bare_model(markers: tuple[str, ...], segments: Mapping[str, tuple[str, ...]] | None = None) -> SubjectModel:
    """A model that knows names and segments alone, where nothing is known of distances."""
    number, unknown = {name: k for k, name in enumerate(markers)}, np.full((len(markers), len(markers)), np.nan)
    groups = {name: tuple(number[m] for m in some if m in number) for name, some in (segments or {}).items()}
    parts = tuple(Segment(name, some, np.zeros((len(some), 3)), NO_PARENT) for name, some in groups.items())
    return SubjectModel(markers, parts, unknown, unknown)


def segments_of(sidecar: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """The segments that a sidecar names, and their markers."""
    return {segment["name"]: tuple(segment["markers"]) for segment in sidecar.get("segments", ())}


def _cut(tracks: Trajectories, places: Collection[Place], recording: Recording) -> Trajectories:
    cuts = []
    for column, frame in sorted(places):
        (slot,) = np.flatnonzero(tracks.column[frame] == recording.columns.index(column))
        if tracks.start[tracks.index[frame, slot]] < frame:
            cuts.append((tracks.index[frame, slot], frame))
    return tracks.cut(*map(np.array, zip(*cuts)))[0] if cuts else tracks


def _links(rows: Any, recording: Recording, joined: set[Place]) -> Int[np.ndarray, "frames columns"]:
    """The column in the next frame that continues each point, `NO_MATCH` where its trajectory ends."""
    place = {column: k for k, column in enumerate(recording.columns)}
    links = np.full(recording.points.shape[:2], NO_MATCH, np.int32)
    begins = {_begin(row) for row in rows}
    for row in rows:
        runs = _runs(row)
        for k, (column, first, last) in enumerate(runs):
            if column not in place or last >= len(links):
                raise ValueError("what is written beside it is about other points; label it again")
            links[first:last, place[column]] = place[column]
            if k + 1 < len(runs):
                links[last, place[column]] = place[runs[k + 1][0]]
            elif (column, last + 1) in joined & begins:
                links[last, place[column]] = place[column]
    return links


def _runs(row: Mapping[str, Any]) -> list[list[int]]:
    return row.get("columns") or [[row["column"], *row["frames"]]]


def _begin(row: Mapping[str, Any]) -> Place:
    column, first, _ = _runs(row)[0]
    return column, first
