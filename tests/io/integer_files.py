"""C3D files of 16-bit integers, as older systems write them."""

from pathlib import Path

import numpy as np

from dshpm_jax import Recording
from dshpm_jax.io._c3d import fresh_layout
from dshpm_jax.io._c3d_format import write_layout
from dshpm_jax.io._c3d_parameters import FLOAT, Parameter, encode_floats, with_parameters


def write_integers(recording: Recording, path: Path) -> None:
    """Writes points as counts of a tenth of a millimetre."""
    file = fresh_layout(recording)
    counts = np.where(recording.present[..., None], recording.points / 0.1, 0).round().astype("<i2")
    words = np.concatenate([counts, np.where(recording.present, 0, -1)[..., None].astype("<i2")], axis=-1)
    file.points = np.ascontiguousarray(words).view("V8")[..., 0]
    scale = encode_floats([0.1], file.processor)
    file.header = file.header[:12] + scale + file.header[16:]
    file.groups = with_parameters(file.groups, "POINT", [Parameter("SCALE", FLOAT, (), scale)])
    write_layout(file, path)
