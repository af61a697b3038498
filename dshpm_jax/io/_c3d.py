"""C3D files to recordings and back."""

import re
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from dshpm_jax._geometry import is_seen
from dshpm_jax._recording import Recording, bare_label, is_unlabelled
from dshpm_jax.io._c3d_format import MAX_FRAMES_FIELD, C3dFile, read_layout, write_layout
from dshpm_jax.io._c3d_parameters import (
    FLOAT,
    INT,
    INTEL,
    Group,
    Parameter,
    byte_order,
    decode_floats,
    encode_floats,
    integers,
    text_parameters,
)
from dshpm_jax.io._doubts import doubts
from dshpm_jax.io._errors import NoPoints, ReadError
from dshpm_jax.io._far import set_far_missing
from dshpm_jax.io._raw import Raw
from dshpm_jax.io._units import HIGHEST_RATE, LOWEST_RATE, MILLIMETRES, length_unit

_OUTPUT_GROUPS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "MODELED_MARKERS")
_CENTRE_OF_MASS = re.compile(r"Cent(re|er)OfMass.*", re.IGNORECASE)


def raw_c3d(path: Path) -> Raw:
    """The points of a C3D file, but for what the file itself says that a model computed."""
    return raw_of(read_layout(path), path)


def raw_of(file: C3dFile, path: Path) -> Raw:
    """What `raw_c3d` gives, for a file that has been read."""
    labels = raw_labels(file)
    if not labels:
        if file.analog.size:
            raise NoPoints(path, "it holds analog samples alone, no points", "give recordings with points")
        raise ReadError(path, "it holds no points", "export it with its trajectories")
    outputs = model_outputs(file, labels)
    columns = [c for c in range(len(labels)) if c not in outputs]
    if not columns:
        raise ReadError(path, "all its points are model outputs", "export it with its markers")
    rate, notes = _rate(file)
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:
        raise ReadError(path, f"its rate is {rate:g} frames a second", "set POINT:RATE")
    unit = length_unit((file.strings("POINT", "UNITS") or [""])[0], path)
    points, residual = _positions(file, columns, MILLIMETRES[unit])
    notes += _about_count(file)
    notes += _set_missing(points, residual)
    notes += set_far_missing(points, MILLIMETRES[unit])
    if file.disagreement and (wrong := doubts(points, ["a name"] * len(columns), rate)):
        raise ReadError(path, f"{file.disagreement}; and as its size has it, {wrong[0]}", "export it again")
    names = tuple(labels[c] for c in columns)
    unmeasured = _unmeasured(points, residual)
    return Raw(path, points, names, tuple(columns), rate, unit, tuple(prefixes_of(file)), unmeasured, tuple(notes))


def write_c3d(recording: Recording, path: str | Path) -> None:
    """Writes the points and labels of `recording` as C3D, in its own unit, and nothing of the file that it came from.

    Coordinates are rounded to single precision. What is at `path` is replaced, whole or not at all.

    Raises:
        WriteError: more points or longer labels than a C3D file holds.
    """
    write_layout(fresh_layout(recording), Path(path))


def raw_labels(file: C3dFile) -> list[str]:
    """A label for each point as the file has it; points beyond the list of labels have none."""
    width = file.points.shape[1]
    return (file.strings("POINT", "LABELS") + [""] * width)[:width]


def model_outputs(file: C3dFile, labels: list[str]) -> set[int]:
    """Columns that some biomechanical model computed: angles, forces, axes of segments, centres of mass."""
    listed = {name for group in _OUTPUT_GROUPS for name in file.strings("POINT", group)}
    bare = [bare_label(name) for name in labels]
    # Plug-in Gait stores a segment's axes as four points: PELO, PELA, PELL, PELP.
    stems = {name[:-1] for name in bare if len(name) > 2}
    axes = {stem + end for stem in stems if {stem + end for end in "OALP"} <= set(bare) for end in "OALP"}
    return {
        c
        for c, name in enumerate(labels)
        if not is_unlabelled(bare[c]) and (name in listed or bare[c] in axes or _CENTRE_OF_MASS.fullmatch(bare[c]))
    }


def prefixes_of(file: C3dFile) -> list[str]:
    """What SUBJECTS:LABEL_PREFIXES puts before labels, where the file says that it does; the longest first."""
    if not file.number("SUBJECTS", "USES_PREFIXES"):
        return []
    return sorted(filter(None, file.strings("SUBJECTS", "LABEL_PREFIXES")), key=len, reverse=True)


def fresh_layout(recording: Recording, first: int = 1) -> C3dFile:
    """A C3D file in memory that holds `recording` alone, as floating point numbers in its own unit.

    Arguments:
        first: number of its first frame.
    """
    frames, width = recording.points.shape[:2]
    records = np.zeros((frames, width, 4), "<f4")
    seen = recording.present
    records[..., :3][seen] = recording.points[seen] / MILLIMETRES[recording.unit]
    records[..., 3] = np.where(seen, 0, -1)
    header = bytearray(512)
    header[1] = 0x50
    last = first + frames - 1
    header[6:10] = integers([min(number, MAX_FRAMES_FIELD) for number in (first, last)], INTEL)
    header[12:16] = encode_floats([-1.0], INTEL)  # a negative scale says: floating point
    header[20:24] = encode_floats([recording.rate], INTEL)
    points = np.ascontiguousarray(records).view("V16").reshape(frames, width)
    return C3dFile(bytes(header), INTEL, _fresh_groups(recording, first), points, np.zeros((frames, 0), np.uint8))


def _fresh_groups(recording: Recording, first: int) -> list[Group]:
    frames, width = recording.points.shape[:2]
    point = [
        Parameter("USED", INT, (), integers([min(width, 0xFFFF)], INTEL)),
        Parameter("FRAMES", INT, (), integers([min(frames, MAX_FRAMES_FIELD)], INTEL)),
        Parameter("LONG_FRAMES", FLOAT, (), encode_floats([frames], INTEL)),
        Parameter("SCALE", FLOAT, (), encode_floats([-1.0], INTEL)),
        Parameter("RATE", FLOAT, (), encode_floats([recording.rate], INTEL)),
        Parameter("DATA_START", INT, (), integers([0], INTEL)),
        *text_parameters("UNITS", [recording.unit]),
        *text_parameters("LABELS", recording.labels),
    ]
    ends = {"START": first, "END": first + frames - 1}
    trial = [
        Parameter(f"ACTUAL_{end}_FIELD", INT, (2,), integers([number & 0xFFFF, number >> 16], INTEL))
        for end, number in ends.items()
    ]
    analog = [Parameter("USED", INT, (), integers([0], INTEL))]
    names = {"POINT": point, "ANALOG": analog, "TRIAL": trial}
    return [Group(k + 1, name, parameters=found) for k, (name, found) in enumerate(names.items())]


def _rate(file: C3dFile) -> tuple[float, list[str]]:
    """Frames a second: POINT:RATE, or the header's where that parameter is not there; what to say if they disagree."""
    said = float(decode_floats(np.frombuffer(file.header[20:24], np.uint8), file.processor)[0])
    rate = file.number("POINT", "RATE")
    if rate is None:
        return said, []
    if LOWEST_RATE <= said <= HIGHEST_RATE and abs(said - rate) > 0.01 * abs(rate):
        return rate, [f"its header says {said:g} frames a second and POINT:RATE {rate:g}: the latter is taken"]
    return rate, []


def _positions(
    file: C3dFile, columns: list[int], unit: float
) -> tuple[Float[np.ndarray, "frames points 3"], Float[np.ndarray, "frames points"]]:
    """Positions in millimetres and residuals as the file counts them; `unit` is the length of the file's unit."""
    records = np.ascontiguousarray(file.points[:, columns])
    raw = records.view(np.uint8).reshape(*records.shape, file.points.dtype.itemsize)
    with np.errstate(over="ignore", invalid="ignore"):  # of bytes that are no numbers; such points count as missing
        if raw.shape[-1] == 8:
            words = np.ascontiguousarray(raw).view(byte_order(file.processor) + "i2")
            points = words[..., :3] * file.count
        else:
            words = decode_floats(raw, file.processor)
            points = words[..., :3].astype(np.float64)
        points *= unit
    return points, words[..., 3]


def _unmeasured(
    points: Float[np.ndarray, "frames points 3"], residual: Float[np.ndarray, "frames points"]
) -> Bool[np.ndarray, " points"] | None:
    """Columns that have no residual and no cameras in any frame: computed ones, where most others do have them."""
    seen = is_seen(points)
    marked = (seen & (residual != 0)).sum(0)
    there = seen.any(0)
    measured = there & (marked > 0.5 * seen.sum(0))
    return there & (marked == 0) if 2 * measured.sum() > there.sum() else None


def _about_count(file: C3dFile) -> list[str]:
    """What to say where header and parameters disagree about the length of one count: no size of a file tells."""
    said = file.number("POINT", "SCALE") or 0.0
    if file.points.dtype.itemsize != 8 or said <= 0 or abs(said - file.count) <= 0.01 * file.count:
        return []
    return [
        f"one count is {file.count:.4g} by its header and {said:.4g} by POINT:SCALE: the former is taken, "
        "check that sizes are right"
    ]


def _set_missing(
    points: Float[np.ndarray, "frames points 3"], residual: Float[np.ndarray, "frames points"]
) -> list[str]:
    """Capture systems mark a point that was not seen by a negative residual, by the origin, or by NaN.

    Where that leaves nothing the residuals are wrong, not the points: they stay, and a sentence says so.
    """
    there = np.isfinite(points).all(-1) & (points != 0).any(-1)
    seen = there & ~(residual < 0)
    wrong = there.any() and not seen.any()
    points[~(there if wrong else seen)] = np.nan
    return ["all its points are marked as missing and have coordinates: taken for seen"] if wrong else []
