"""How a file numbers its frames: many are cut from longer captures and do not begin at 1."""

from pathlib import Path

import numpy as np

from dshpm_jax.io._c3d_format import read_layout
from dshpm_jax.io._c3d_parameters import byte_order


def first_frame(path: str | Path) -> int:
    """The number that the first frame of a C3D or TRC file has in its own counting."""
    path = Path(path)
    return _first_of_trc(path) if path.suffix.lower() == ".trc" else _first_of_c3d(path)


def _first_of_c3d(path: Path) -> int:
    """TRIAL:ACTUAL_START_FIELD, two 16-bit halves, or else the header's 16 bits."""
    file = read_layout(path)
    field = file.find("TRIAL", "ACTUAL_START_FIELD")
    halves = field.numbers(file.processor)[:2] if field is not None else []
    if len(halves) == 2:
        return int(halves[0]) % 0x10000 + (int(halves[1]) % 0x10000 << 16)
    return int(np.frombuffer(file.header[6:8], byte_order(file.processor) + "u2")[0])


def _first_of_trc(path: Path) -> int:
    """The first cell of the first row that begins with a number below the row of labels; 1 if there is none."""
    below = False
    for line in path.read_bytes().decode("utf-8-sig", "replace").splitlines():
        cells = line.split(maxsplit=1)
        if below and cells and cells[0].isdigit():
            return int(cells[0])
        below |= line.lower().startswith("frame#")
    return 1
