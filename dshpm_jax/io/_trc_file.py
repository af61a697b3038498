"""New TRC files, as OpenSim reads them."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from dshpm_jax._recording import Recording
from dshpm_jax.io._atomic import write_whole
from dshpm_jax.io._units import MILLIMETRES

DIGITS = {"mm": 5, "cm": 6, "m": 8}
"""Digits behind the point: 10 nanometres, finer than the single precision of C3D files within some metres."""

_KEYS = ("DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units", "OrigDataRate", "OrigDataStartFrame")


def write_trc(recording: Recording, first: int, path: str | Path) -> None:
    """Writes the points and labels of `recording` as TRC, in its own unit; cells without a point are empty.

    What is at `path` is replaced, whole or not at all.

    Arguments:
        first: number of its first frame, at the time 0.
    """
    path = Path(path)
    write_whole(path, (f"{line}\r\n".encode() for line in _lines(recording, first, path.name)))


def _lines(recording: Recording, first: int, name: str) -> Iterator[str]:
    frames, points = recording.points.shape[:2]
    rate = f"{recording.rate:.10g}"
    yield "\t".join(("PathFileType", "4", "(X/Y/Z)", name))
    yield "\t".join((*_KEYS, "OrigNumFrames"))
    yield "\t".join((rate, rate, str(frames), str(points), recording.unit, rate, str(first), str(frames)))
    yield "\t".join(("Frame#", "Time", *(cell for label in recording.labels for cell in (label, "", ""))))
    yield "\t".join(("", "", *(f"{axis}{k + 1}" for k in range(points) for axis in "XYZ")))
    yield ""
    places = recording.points / MILLIMETRES[recording.unit]
    digits = DIGITS[recording.unit]
    for t, frame in enumerate(places):
        cells = ("" if np.isnan(value) else f"{value:.{digits}f}" for value in frame.ravel().tolist())
        yield "\t".join((str(first + t), f"{t / recording.rate:.6f}", *cells))
