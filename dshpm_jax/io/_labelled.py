"""A labelling as a file: labels and the order of columns change, and nothing else."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Int

from dshpm_jax._geometry import is_seen
from dshpm_jax._labelling import Labelling
from dshpm_jax._recording import Recording, bare_label, is_unlabelled
from dshpm_jax._types import NO_MATCH
from dshpm_jax.io._atomic import write_whole
from dshpm_jax.io._c3d import fresh_layout, prefixes_of, raw_labels, raw_of
from dshpm_jax.io._c3d_format import C3dFile, missing_record, read_layout, write_layout
from dshpm_jax.io._c3d_parameters import INT, Parameter, integers, text_parameters, with_parameters
from dshpm_jax.io._errors import ReadError, WriteError
from dshpm_jax.io._form import AS_IT_IS, Form
from dshpm_jax.io._frame_numbers import first_frame
from dshpm_jax.io._names import names_as_before
from dshpm_jax.io._raw import Raw
from dshpm_jax.io._text import TABLES, text_table
from dshpm_jax.io._text_table import encoded, raw_of_table, rearranged_lines
from dshpm_jax.io._trc_file import write_trc


def write_labelled(labelling: Labelling, path: str | Path, form: Form = AS_IT_IS) -> None:
    """Writes the recording with its labels as C3D, as TRC, or in the format of the file that it came from.

    First the model's markers in the model's order (one that was never found is a column without points), then what
    stayed unlabelled, a column for each source column that has any left: with the number that the capture system gave
    it, or `*1`, `*2`, ... Then come the columns of the source file that the recording leaves out. Names keep the prefix
    of their subject. Points keep their coordinates, residuals and camera masks bit by bit, and so do those that the
    reader took for gaps; analog samples, events, rates and all other parameters come from the source file as they are.
    The ending of `path` says which format; in text files numbers stay as they are spelt.

    A recording that came from no file, or from one of another format, makes a fresh one, and so does a `form` with
    other axes or another unit: it holds the points and their names alone, without those that the recording leaves out.

    Raises:
        WriteError: no such format can be written, or the source file has other points now.
    """
    path, source = Path(path), labelling.recording.source
    same = source is not None and source.suffix.lower() == path.suffix.lower() and not form.changes_points
    if path.suffix.lower() == ".trc" and not same:
        write_trc(*_fresh(labelling, form), path)
    elif path.suffix.lower() in TABLES:
        _write_text(labelling, path, form)
    elif not same:
        write_layout(fresh_layout(*_fresh(labelling, form)), path)
    else:
        _write_c3d(labelling, path, form)


def _fresh(labelling: Labelling, form: Form) -> tuple[Recording, int]:
    """The labelled recording as it is written without its source file, and the number of its first frame."""
    recording = labelling.recording
    labels, prefixes = as_spelt(recording)
    left = _unlabelled_columns(labelling, tuple(range(len(labels))), recording.present)
    names = names_as_before(labelling.model.markers, left, labels, prefixes, form.keep_unknown)
    labelled = replace(labelling.to_recording(), labels=tuple(names), source=recording.source)
    return form.of(labelled), first_number(recording.source)


def as_spelt(recording: Recording) -> tuple[Sequence[str], Sequence[str]]:
    """The labels of a recording with the prefixes that its file has, and those that end in no colon."""
    source = recording.source
    try:
        if source is not None and source.suffix.lower() == ".c3d":
            file = read_layout(source)
            labels, prefixes = raw_labels(file), prefixes_of(file)
        elif source is not None:
            labels, prefixes = text_table(source).labels, ()
        else:
            return recording.labels, ()
        spelt = [labels[column].strip() for column in recording.columns]
    except (ReadError, IndexError):  # it changed, or is no longer there
        return recording.labels, ()
    whole = [new if new.endswith(old) and old else old for new, old in zip(spelt, recording.labels)]
    return [new if is_unlabelled(bare_label(new)) else name for new, name in zip(spelt, whole)], prefixes


def _write_c3d(labelling: Labelling, path: Path, form: Form) -> None:
    recording = labelling.recording
    file, columns, there = source_layout(recording)
    found, left = _marker_columns(labelling, columns), _unlabelled_columns(labelling, columns, there)
    outputs = [c for c in range(file.points.shape[1]) if c not in set(columns)]
    names = _left_out(labelling, [raw_labels(file)[c] for c in outputs])
    source = np.concatenate([found, left, np.broadcast_to(outputs, (len(found), len(outputs)))], axis=1)
    labels = raw_labels(file)
    own = names_as_before(labelling.model.markers, left, labels, prefixes_of(file), form.keep_unknown)
    write_layout(_rearranged(file, source.astype(int), [*own, *names]), path)


def _write_text(labelling: Labelling, path: Path, form: Form) -> None:
    recording = labelling.recording
    if form.changes_points:
        raise WriteError(path, "axes and units are changed in C3D and TRC alone", "give a name that ends in .trc")
    if recording.source is None or recording.source.suffix.lower() != path.suffix.lower():
        remedy = "give a name that ends in .c3d or .trc"
        raise WriteError(path, "text is written only in the format that the recording was read in", remedy)
    table = text_table(recording.source)
    raw = raw_of_table(table)
    there = _seen_in_source(raw, recording)
    found = _marker_columns(labelling, recording.columns)
    left = _unlabelled_columns(labelling, recording.columns, there)
    outputs = [c for c in range(len(table.labels)) if c not in set(recording.columns)]
    rest = _left_out(labelling, [table.labels[c] for c in outputs])
    source = np.concatenate([found, left, np.broadcast_to(outputs, (len(found), len(outputs)))], axis=1).astype(int)
    names = [*names_as_before(labelling.model.markers, left, table.labels, (), form.keep_unknown), *rest]
    write_whole(path, encoded(rearranged_lines(table, source, names, is_seen(raw.points)), table.file))


def _seen_in_source(raw: Raw, recording: Recording) -> Bool[np.ndarray, "frames points"]:
    """Where the source has a point in a column of `recording`, taken for a gap or not.

    Raises:
        WriteError: points of the recording are not those of the file.
    """
    place = {column: k for k, column in enumerate(raw.columns)}
    if set(recording.columns) <= place.keys() and len(raw.points) == recording.num_frames:
        points = raw.points[:, [place[column] for column in recording.columns]]
        seen = recording.present
        if np.array_equal(points[seen], recording.points[seen]):
            return is_seen(points)
    remedy = "label it again, or set the recording's source to None to write the points in memory"
    raise WriteError(raw.path, "the file has other points than the recording that was labelled", remedy)


def _left_out(labelling: Labelling, names: Sequence[str]) -> Sequence[str]:
    """The names of columns that the recording leaves out; none may be that of a marker as well."""
    source, both = labelling.recording.source, sorted(set(labelling.model.markers) & set(names))
    if source is not None and both:
        remedy = "make the model without it"
        raise WriteError(source, f"'{both[0]}' is a marker of the model and a model output of the file", remedy)
    return names


def source_layout(
    recording: Recording, fresh: bool = False
) -> tuple[C3dFile, tuple[int, ...], Bool[np.ndarray, "frames points"]]:
    """The file to take records from, the column in it of each column of `recording`, and where that has a point.

    Arguments:
        fresh: whether a new file is made, although the recording came from a C3D file.
    """
    if fresh or recording.source is None or recording.source.suffix.lower() != ".c3d":
        columns = tuple(range(recording.points.shape[1]))
        return fresh_layout(recording, first_number(recording.source)), columns, recording.present
    file = read_layout(recording.source)
    return file, recording.columns, _seen_in_source(raw_of(file, recording.source), recording)


LARGEST_FIRST_FRAME = 1 << 31
"""C3D files hold the numbers of frames in 32 bits."""


def first_number(source: Path | None) -> int:
    """What the first frame is called in the file that a recording came from; C3D files count from 1."""
    try:
        number = 1 if source is None else max(1, first_frame(source))
        return number if number < LARGEST_FIRST_FRAME else 1
    except ReadError:  # it is no longer there
        return 1


def _marker_columns(labelling: Labelling, columns: tuple[int, ...]) -> Int[np.ndarray, "frames markers"]:
    """For each marker the source column that holds it in each frame, or `NO_MATCH`."""
    identities = labelling.identities
    found = np.full((len(identities), labelling.model.num_markers), NO_MATCH)
    frame, column = np.nonzero(identities != NO_MATCH)
    found[frame, identities[frame, column]] = np.asarray(columns)[column]
    return found


def _unlabelled_columns(
    labelling: Labelling, columns: tuple[int, ...], there: Bool[np.ndarray, "frames points"]
) -> Int[np.ndarray, "frames columns"]:
    """Source columns that hold unlabelled points, `NO_MATCH` in frames where their point has a label.

    Frames in which the source sees no point keep its own record.

    Arguments:
        there: where the source has a point, be it one that the reader took for a gap.
    """
    labelled = labelling.identities != NO_MATCH
    rest = np.flatnonzero((there & ~labelled).any(0))
    return np.where(labelled[:, rest], NO_MATCH, np.asarray(columns, dtype=int)[rest])


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
