"""What makes a recording doubtful is said, and nothing is changed; numbers for missing points are none."""

import numpy as np
import pytest

from dshpm_jax import Recording, io
from dshpm_jax.io._doubts import doubts
from dshpm_jax.io._far import set_far_missing

NAMES = tuple("ABCDE")


def walking(frames=200, seed=1):
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.normal(2, 1, (frames, 5, 3)), axis=0) + rng.uniform(-500, 500, (1, 5, 3))


def test_a_sound_recording_raises_none():
    points = walking()
    points[50:120, 1] = points[:160, 2] = np.nan
    assert doubts(points, NAMES, 100.0) == []


def test_leaps_of_all_points():
    points = walking()
    points[77:, :, 0] += 3000
    assert doubts(points, NAMES, 100.0) == ["all its points leap by 3 m or more after frame 77"]
    assert doubts(points, NAMES, 1.0) == []
    points[150:] += 3000
    assert doubts(points, NAMES, 100.0)[0].endswith("after frame 77 and 1 more")


def test_one_point_may_leap_and_unnamed_columns_may_hold_any():
    points = walking()
    points[77:, :3] += 3000
    assert doubts(points, NAMES, 100.0) == []
    points[77:] += 3000
    assert doubts(points, tuple(f"*{k}" for k in range(5)), 100.0) == []


def test_beyond_any_room():
    points = walking()
    points[3, 2] = [0, 0, -120_000]
    assert doubts(points, NAMES, 100.0) == [
        "it has coordinates up to 120 m, which no room holds; check its length unit"
    ]


def test_scattered_gaps():
    points = walking()
    points[np.random.default_rng(0).random((200, 5)) < 0.36] = np.nan
    (said,) = doubts(points, NAMES, 100.0)
    assert "of its points are missing, scattered" in said


@pytest.mark.parametrize("number, unit", [(9999999, 1), (1e7, 1), (9999, 1), (-99999, 1), (99999, 10), (9999, 1000)])
def test_numbers_for_missing_points(number, unit):
    points = np.full((4, 2, 3), 55.0)
    points[1, 1] = number * unit
    (said,) = set_far_missing(points, unit)
    assert said == "1 points at " + f"{abs(number):.7g}" + ", where no room reaches, are taken for missing"
    assert np.isnan(points[1, 1]).all() and np.isfinite(points).sum() == 21


def test_far_points_of_a_sound_file_stay():
    points = np.array([[[9999.0, 9999.0, 9998.0], [70_000, 1, 1]]])
    assert set_far_missing(points, 1.0) == [] and np.isfinite(points).all()


def test_all_residuals_negative(tmp_path):
    """The points are there and only their marks are wrong; one that is marked as seen is enough to believe them."""
    file = io._c3d.fresh_layout(Recording(walking(), NAMES, 100.0))
    records = file.points.view("<f4").reshape(200, 5, 4)
    records[..., 3] = -1
    records[0, 0] = 0, 0, 0, -1
    io._c3d_format.write_layout(file, tmp_path / "a.c3d")
    found = io.read(tmp_path / "a.c3d")
    assert found.present.sum() == 999 and "marked as missing" in found.notes[0]
    records[5, 1, 3] = 0
    io._c3d_format.write_layout(file, tmp_path / "b.c3d")
    assert io.read(tmp_path / "b.c3d").present.sum() == 1 and not io.read(tmp_path / "b.c3d").notes
