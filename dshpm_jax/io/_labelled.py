"""A labelling as a file: labels and the order of columns change, and nothing else."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Int

from dshpm_jax._labelling import Labelling
from dshpm_jax._recording import Recording
from dshpm_jax._types import NO_MATCH
from dshpm_jax.io._atomic import write_whole
from dshpm_jax.io._c3d import fresh_layout, raw_labels, recording_of
from dshpm_jax.io._c3d_format import C3dFile, missing_record, read_layout, write_layout
from dshpm_jax.io._c3d_parameters import INT, Parameter, integers, text_parameters, with_parameters
from dshpm_jax.io._errors import ReadError, WriteError
from dshpm_jax.io._frame_numbers import first_frame
from dshpm_jax.io._text import TABLES, text_table
from dshpm_jax.io._text_table import encoded, rearranged_lines, recording_of_table

_ANY_NAME = ("*",)  # which names the source has does not matter any more, so none can stand against another


def write_labelled(labelling: Labelling, path: str | Path) -> None:
    """Writes the recording with its labels as C3D, or in the format of the file that it came from.

    First the model's markers in the model's order (one that was never found is a column without points), then what
    stayed unlabelled as `*1`, `*2`, ..., a column for each source column that has any left, then the model outputs
    of the source file. Points keep their coordinates, residuals and camera masks bit by bit; analog samples,
    events, rates and all other parameters come from the source file as they are. A recording that came from no C3D
    file makes a fresh one. The ending of `path` says which format; in text files numbers stay as they are spelt.
    """
    if Path(path).suffix.lower() in TABLES:
        _write_text(labelling, Path(path))
        return
    recording = labelling.recording
    file, columns = source_layout(recording)
    found, left = _marker_columns(labelling, columns), _unlabelled_columns(labelling, columns)
    outputs = [c for c in range(file.points.shape[1]) if c not in set(columns)]
    _check_apart(labelling.model.markers, [raw_labels(file)[c] for c in outputs], recording.source)
    source = np.concatenate([found, left, np.broadcast_to(outputs, (len(found), len(outputs)))], axis=1)
    write_layout(_rearranged(file, source.astype(int), _names(labelling, file, left.shape[1], outputs)), Path(path))


def _write_text(labelling: Labelling, path: Path) -> None:
    recording = labelling.recording
    if recording.source is None or recording.source.suffix.lower() != path.suffix.lower():
        remedy = "give a name that ends in .c3d"
        raise WriteError(path, "text is written only in the format that the recording was read in", remedy)
    table = text_table(recording.source)
    _check_unchanged(recording_of_table(table, _ANY_NAME), recording, recording.source)
    found, left = _marker_columns(labelling, recording.columns), _unlabelled_columns(labelling, recording.columns)
    names = [*labelling.model.markers, *(f"*{k + 1}" for k in range(left.shape[1]))]
    lines = rearranged_lines(table, np.concatenate([found, left], axis=1).astype(int), names, recording.present)
    write_whole(path, encoded(lines, table.file))


def _check_unchanged(now: Recording, recording: Recording, source: Path) -> None:
    if now.columns != recording.columns or not np.array_equal(now.points, recording.points, equal_nan=True):
        remedy = "label it again, or set the recording's source to None to write the points in memory"
        raise WriteError(source, "the file has other points than the recording that was labelled", remedy)


def _check_apart(markers: Sequence[str], outputs: Sequence[str], source: Path | None) -> None:
    both = sorted(set(markers) & set(outputs))
    if source is not None and both:
        remedy = "make the model without it"
        raise WriteError(source, f"'{both[0]}' is a marker of the model and a model output of the file", remedy)


def source_layout(recording: Recording) -> tuple[C3dFile, tuple[int, ...]]:
    """The file to take records from, and the column in it of each column of `recording`."""
    if recording.source is None or recording.source.suffix.lower() != ".c3d":
        return fresh_layout(recording, _first_number(recording.source)), tuple(range(recording.points.shape[1]))
    file = read_layout(recording.source)
    _check_unchanged(recording_of(file, recording.source, _ANY_NAME), recording, recording.source)
    return file, recording.columns


def _first_number(source: Path | None) -> int:
    """What the first frame is called in the file that a recording came from; C3D files count from 1."""
    try:
        return 1 if source is None else max(1, first_frame(source))
    except ReadError:  # it is no longer there
        return 1


def _marker_columns(labelling: Labelling, columns: tuple[int, ...]) -> Int[np.ndarray, "frames markers"]:
    """For each marker the source column that holds it in each frame, or `NO_MATCH`."""
    identities = labelling.identities
    found = np.full((len(identities), labelling.model.num_markers), NO_MATCH)
    frame, column = np.nonzero(identities != NO_MATCH)
    found[frame, identities[frame, column]] = np.asarray(columns)[column]
    return found


def _unlabelled_columns(labelling: Labelling, columns: tuple[int, ...]) -> Int[np.ndarray, "frames columns"]:
    """Source columns that hold unlabelled points, `NO_MATCH` in frames where their point has a label.

    Frames in which the source sees no point keep its own record.
    """
    labelled = labelling.identities != NO_MATCH
    rest = np.flatnonzero((labelling.recording.present & ~labelled).any(0))
    return np.where(labelled[:, rest], NO_MATCH, np.asarray(columns, dtype=int)[rest])


def _names(labelling: Labelling, file: C3dFile, num_left: int, outputs: list[int]) -> list[str]:
    labels = raw_labels(file)
    return [*labelling.model.markers, *(f"*{k + 1}" for k in range(num_left)), *(labels[c] for c in outputs)]


def _rearranged(file: C3dFile, source: Int[np.ndarray, "frames columns"], names: list[str]) -> C3dFile:
    """The file with column `k` taken from column `source[t, k]` in frame `t` and named `names[k]`."""
    nothing = np.full((len(file.points), 1), missing_record(file), dtype=file.points.dtype)
    records = np.concatenate([file.points, nothing], axis=1)  # NO_MATCH is -1: the last column
    points = np.take_along_axis(records, source % records.shape[1], axis=1)
    used = Parameter("USED", INT, (), integers([min(len(names), 0xFFFF)], file.processor))
    new = [used, *text_parameters("LABELS", names), *_descriptions(file, source)]
    groups = with_parameters(file.groups, "POINT", new, drop=r"(LABELS|DESCRIPTIONS)\d*")
    return replace(file, points=points, groups=groups)


def _descriptions(file: C3dFile, source: Int[np.ndarray, "frames columns"]) -> list[Parameter]:
    """The descriptions of columns that come from one column of the source, if the source has any."""
    old = file.strings("POINT", "DESCRIPTIONS")
    if not old:
        return []
    low = np.where(source == NO_MATCH, len(file.points[0]), source).min(0)
    same = low == source.max(0)
    texts = [old[c] if alone and c < len(old) else "" for c, alone in zip(low, same, strict=True)]
    return text_parameters("DESCRIPTIONS", texts)
