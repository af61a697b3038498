"""How a file numbers its frames: many are cut from longer captures and do not begin at 1."""

from pathlib import Path

import numpy as np

from dshpm_jax.io._c3d_format import read_layout
from dshpm_jax.io._c3d_parameters import byte_order
from dshpm_jax.io._text import TABLES, text_table


def first_frame(path: str | Path) -> int:
    """The number that the first frame of a recording's file has in its own counting."""
    path = Path(path)
    return text_table(path).first_frame() if path.suffix.lower() in TABLES else _first_of_c3d(path)


def _first_of_c3d(path: Path) -> int:
    """TRIAL:ACTUAL_START_FIELD, two 16-bit halves, or else the header's 16 bits."""
    file = read_layout(path)
    field = file.find("TRIAL", "ACTUAL_START_FIELD")
    halves = field.numbers(file.processor)[:2] if field is not None else []
    if len(halves) == 2:
        return int(halves[0]) % 0x10000 + (int(halves[1]) % 0x10000 << 16)
    return int(np.frombuffer(file.header[6:8], byte_order(file.processor) + "u2")[0])
