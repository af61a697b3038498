"""TRC text files (Motion Analysis, OpenSim) to recordings."""

import re
from pathlib import Path

import numpy as np
from jaxtyping import Float

from dshpm_jax._recording import Recording
from dshpm_jax.io._c3d import bare_labels
from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._units import MILLIMETRES, length_unit

_AXES_ROW = re.compile(r"\s*X1\b", re.IGNORECASE)


def read_trc(path: Path) -> Recording:
    """The markers of a TRC file."""
    lines = _lines(path)
    labels_at = next((k for k, line in enumerate(lines) if line.lower().startswith("frame#")), None)
    if labels_at is None or labels_at < 2:
        raise ReadError(path, "this is no TRC file (it has no 'Frame#' row)", "give a C3D or TRC file")
    header = _header(lines[:labels_at])
    labels = _labels(_cells(lines[labels_at]))
    if not labels:
        raise ReadError(path, "it holds no points", "export it with its trajectories")
    rate = _number(header, "datarate", path)
    if not (np.isfinite(rate) and rate > 0):
        raise ReadError(path, f"its DataRate is {rate:g} frames a second", "set it in the file's third line")
    unit = length_unit(header.get("units", ""), path)
    points = _positions(lines, labels_at + 1, len(labels), path) * MILLIMETRES[unit]
    announced = _number(header, "numframes", path) if header.get("numframes") else len(points)
    if len(points) < announced:
        wrong = f"it announces {announced:g} frames and ends after {len(points)} (truncated)"
        raise ReadError(path, wrong, "copy or export it again, or correct NumFrames")
    if not len(points):
        raise ReadError(path, "it holds no frames", "export it again")
    points[(points == 0).all(-1) | ~np.isfinite(points).all(-1)] = np.nan
    if not np.isfinite(points).any():
        raise ReadError(path, "not one point was seen in any frame", "export it with its trajectories")
    return Recording(points, bare_labels(labels, path), rate, unit, path)


def _lines(path: Path) -> list[str]:
    try:
        text = path.read_bytes().decode("utf-8-sig", "replace")
    except OSError as error:
        raise ReadError(path, f"cannot be read ({error.strerror})", "check the path and its permissions") from None
    if not text.strip():
        raise ReadError(path, "the file is empty", "export it again")
    return text.splitlines()


def _cells(line: str) -> list[str]:
    """The cells of a row, parted by tabs, or by blanks in files that have no tab at all."""
    return [cell.strip() for cell in line.split("\t")] if "\t" in line else line.split()


def _header(lines: list[str]) -> dict[str, str]:
    """Keys (in lower case) and values: the row that starts with DataRate and the one below it."""
    for keys, values in zip(lines, lines[1:], strict=False):
        if keys.lower().startswith("datarate"):
            return dict(zip((key.lower() for key in _cells(keys)), _cells(values), strict=False))
    return {}


def _labels(cells: list[str]) -> list[str]:
    """The labels stand over the first of three columns each; an empty one is a point without a name."""
    cells = cells[2:]
    while cells and not cells[-1]:
        cells.pop()
    thirds = cells[0::3]
    if any(cell for k, cell in enumerate(cells) if k % 3):  # some writers leave out the two empty cells
        return [cell for cell in cells if cell]
    return thirds


def _number(header: dict[str, str], key: str, path: Path) -> float:
    try:
        return float(header[key])
    except (KeyError, ValueError):
        found = f"is '{header[key]}'" if key in header else "is not there"
        raise ReadError(
            path, f"the number {key} of its header {found}", "set it in the second and third line"
        ) from None


def _positions(lines: list[str], start: int, width: int, path: Path) -> Float[np.ndarray, "frames points 3"]:
    """Rows of a frame number, a time and three coordinates a point; what is empty or cut off is missing."""
    rows = []
    for k, line in enumerate(lines[start:], start + 1):
        if not line.strip() or (not rows and _AXES_ROW.match(line)):
            continue
        cells = _cells(line)[2:]
        if any(cells[3 * width :]):
            raise ReadError(path, f"line {k} has more numbers than its {width} labels need", "export it again")
        try:
            row = [float(cell) if cell else np.nan for cell in cells[: 3 * width]]
        except ValueError:
            raise ReadError(path, f"line {k} holds something that is no number", "export it again") from None
        rows.append(row + [np.nan] * (3 * width - len(row)))
    return np.array(rows, dtype=np.float64).reshape(-1, width, 3)
