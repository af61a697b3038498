"""Frames as files count them."""

import numpy as np
import pytest
from making import make_recording

from dshpm_jax import io
from dshpm_jax.io._c3d_format import read_layout, write_layout
from dshpm_jax.io._c3d_parameters import INT, Parameter, integers, with_parameters


@pytest.mark.parametrize("first", [1, 240, 70_000])
def test_c3d(tmp_path, first):
    path = tmp_path / "walk.c3d"
    io.write_c3d(make_recording(5), path)
    assert io.first_frame(path) == 1
    file = read_layout(path)
    field = Parameter("ACTUAL_START_FIELD", INT, (2,), integers([first & 0xFFFF, first >> 16], file.processor))
    file.groups = with_parameters(file.groups, "TRIAL", [field])
    write_layout(file, path)
    assert io.first_frame(path) == first
    assert np.isfinite(io.read(path).points).any()


@pytest.mark.parametrize("first", [0, 1, 312])
def test_trc(tmp_path, first):
    path = tmp_path / "walk.trc"
    path.write_text(f"PathFileType\nDataRate\tUnits\n100\tmm\nFrame#\tTime\tA\n\t\tX1\tY1\tZ1\n\n{first}\t0\t1\t2\t3\n")
    assert io.first_frame(path) == first
    assert len(io.read(path).points) == 1
