"""A recording with filled gaps as a C3D file that says which points were measured."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool

from dshpm_jax._recording import Recording
from dshpm_jax.io._c3d_format import C3dFile, write_layout
from dshpm_jax.io._c3d_parameters import byte_order, decode_floats, encode_floats
from dshpm_jax.io._errors import WriteError
from dshpm_jax.io._form import AS_IT_IS, Form
from dshpm_jax.io._labelled import as_spelt, first_number, source_layout
from dshpm_jax.io._trc_file import write_trc
from dshpm_jax.io._units import MILLIMETRES

MEASURED = 0x0101
"""One count of residual and one camera, for measured points of files that hold neither; in both bytes, as readers do
not agree which of the two is the residual."""

FARTHEST_COUNT = 32767  # of 16-bit coordinates, in units of the file's scale


def write_filled(
    recording: Recording, mask: Bool[np.ndarray, "frames points"], path: str | Path, form: Form = AS_IT_IS
) -> None:
    """Writes a recording of which some points were filled in, as C3D, or as TRC, which says not which.

    A filled point has the residual 0 and no cameras, the mark of C3D for a point that was computed. Measured points
    keep their records bit by bit; only where a file has no residual above 0 at all do they get the least there is, as
    otherwise nothing would tell them from filled ones. All else comes from the source file, as in `write_labelled`; a
    `form` with other axes or another unit makes a fresh file of the points alone.

    Arguments:
        recording: points in millimetres, filled ones among them.
        mask: which are filled.
        path: the file to write; its ending says which.

    Raises:
        WriteError: the source file has other points now, or its numbers do not reach as far as a filled point.
    """
    anew = form.changes_points or Path(path).suffix.lower() != ".c3d"
    if anew:
        recording = form.of(replace(recording, labels=tuple(as_spelt(recording)[0])))
    if Path(path).suffix.lower() == ".trc":
        write_trc(recording, first_number(recording.source), path)
        return
    points = np.where(mask[..., None], np.nan, recording.points)
    file, columns, _ = source_layout(replace(recording, points=points), anew)
    records = file.points.copy()
    columns = np.asarray(columns, dtype=int)
    if not (_residuals(file) > 0).any():
        _mark(records, file, ~mask & recording.present, columns)
    frame, column = np.nonzero(mask)
    places = recording.points[frame, column] / MILLIMETRES[recording.unit]
    if file.points.dtype.itemsize == 8 and (np.abs(places) > FARTHEST_COUNT * file.count).any():
        remedy = "convert it to floating point, or leave its gaps open"
        raise WriteError(Path(path), "a filled point is farther off than the recording's 16-bit numbers reach", remedy)
    records[frame, columns[column]] = _records(file, places)
    write_layout(replace(file, points=records), Path(path))


def _words(records: np.ndarray) -> np.ndarray:
    """The bytes of four words for each record."""
    return records.view(np.uint8).reshape(*records.shape, 4, -1)


def _residuals(file: C3dFile) -> np.ndarray:
    raw = np.ascontiguousarray(_words(np.ascontiguousarray(file.points))[..., 3, :])
    if raw.shape[-1] == 2:
        return raw.view(byte_order(file.processor) + "i2")[..., 0]
    return decode_floats(raw, file.processor)[..., 0]


def _mark(records: np.ndarray, file: C3dFile, measured: np.ndarray, columns: np.ndarray) -> None:
    """Gives the points `measured` the least residual."""
    frame, column = np.nonzero(measured)
    words = _words(records)
    words[frame, columns[column], 3] = np.frombuffer(_numbers(file, np.array([MEASURED])), np.uint8)


def _records(file: C3dFile, places: np.ndarray) -> np.ndarray:
    """Records of computed points at `places`, in the file's unit."""
    counts = np.round(places / file.count) if file.points.dtype.itemsize == 8 else places
    words = np.concatenate([counts, np.zeros((len(places), 1))], axis=1)
    return np.frombuffer(_numbers(file, words), file.points.dtype)


def _numbers(file: C3dFile, values: np.ndarray) -> bytes:
    if file.points.dtype.itemsize == 8:
        return np.asarray(values, byte_order(file.processor) + "i2").tobytes()
    return encode_floats(values, file.processor)  # type: ignore[arg-type]
