"""Filled recordings as C3D: measured points as they were, filled ones marked, everything else of the file there."""

from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from integer_files import write_integers
from making import make_recording

from dshpm_jax import io
from dshpm_jax.io._c3d_format import read_layout


def filled_from(recording, seed: int = 0):
    gaps = ~recording.present
    points = recording.points.copy()
    points[gaps] = np.random.default_rng(seed).uniform(-900, 900, (int(gaps.sum()), 3))
    return replace(recording, points=points), gaps


@pytest.mark.parametrize("unit", ["mm", "m"])
def test_filled_points_have_no_residual_and_measured_ones_have(tmp_path, unit):
    recording = make_recording(50, unit=unit)
    filled, mask = filled_from(recording)
    io.write_filled(filled, mask, tmp_path / "filled.c3d")
    found = ezc3d.c3d(str(tmp_path / "filled.c3d"))
    residual = found["data"]["meta_points"]["residuals"][0].T
    assert (residual[mask] == 0).all() and (residual[~mask] > 0).all()
    back = io.read(tmp_path / "filled.c3d")
    np.testing.assert_allclose(back.points, filled.points, rtol=1e-6, atol=1e-3)


def test_measured_records_stay_bit_by_bit_where_the_file_has_residuals(tmp_path):
    io.write_c3d(make_recording(50), tmp_path / "raw.c3d")
    raw = bytearray((tmp_path / "raw.c3d").read_bytes())
    file = read_layout(tmp_path / "raw.c3d")
    words = file.points.view("<f4").reshape(*file.points.shape, 4).copy()
    words[..., 3] = np.where(words[..., 3] < 0, -1, 515.0)  # cameras and a residual
    at = raw.index(file.points.tobytes())
    raw[at : at + words.nbytes] = words.tobytes()
    (tmp_path / "raw.c3d").write_bytes(raw)
    filled, mask = filled_from(io.read(tmp_path / "raw.c3d"))
    io.write_filled(filled, mask, tmp_path / "filled.c3d")
    before, after = (read_layout(tmp_path / name).points for name in ("raw.c3d", "filled.c3d"))
    assert (before[~mask] == after[~mask]).all()
    assert not after.view("<f4").reshape(*after.shape, 4)[mask][:, 3].any()


def test_all_else_of_a_file_stays(tmp_path, data: Path):
    path = data / "vicon-fullbody-52-vsk" / "squat.c3d"
    recording = io.read(path)
    io.write_filled(recording, np.zeros(recording.points.shape[:2], bool), tmp_path / "same.c3d")
    before, after = read_layout(path), read_layout(tmp_path / "same.c3d")
    assert before.analog.tobytes() == after.analog.tobytes()
    assert [g.name for g in before.groups] == [g.name for g in after.groups]
    np.testing.assert_array_equal(io.read(tmp_path / "same.c3d").points, recording.points)


def test_a_source_that_has_changed_is_refused(tmp_path):
    io.write_c3d(make_recording(50), tmp_path / "raw.c3d")
    filled, mask = filled_from(io.read(tmp_path / "raw.c3d"))
    io.write_c3d(make_recording(50, seed=3), tmp_path / "raw.c3d")
    with pytest.raises(io.WriteError, match="other points"):
        io.write_filled(filled, mask, tmp_path / "filled.c3d")


def test_a_filled_point_beyond_16_bits_is_refused(tmp_path):
    """It would come out on the other side."""
    recording = make_recording(20, labels=["A", "B"])
    write_integers(recording, tmp_path / "raw.c3d")
    filled, mask = filled_from(io.read(tmp_path / "raw.c3d"))
    io.write_filled(filled, mask, tmp_path / "near.c3d")
    np.testing.assert_allclose(io.read(tmp_path / "near.c3d").points[mask], filled.points[mask], atol=0.051)
    filled.points[np.argwhere(mask)[0, 0], np.argwhere(mask)[0, 1], 0] = 3300.0
    with pytest.raises(io.WriteError, match="farther off than the recording's 16-bit numbers reach"):
        io.write_filled(filled, mask, tmp_path / "far.c3d")
    assert not (tmp_path / "far.c3d").exists()
