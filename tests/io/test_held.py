"""Gaps that a program held at the last value."""

import numpy as np
import pytest
from making import make_labelling

from dshpm_jax import Recording, io
from dshpm_jax.io._held import held_points

FRAMES = 60


def moving(seed=0, points=6, speed=5.0, noise=0.3):
    rng = np.random.default_rng(seed)
    start = rng.uniform(-1000, 1000, (1, points, 3))
    walk = np.cumsum(rng.normal([speed, 0, 0], noise, (FRAMES, points, 3)), axis=0)
    return (start + walk).astype(np.float32).astype(float)


def frozen(points, column, first, last):
    """The point keeps its place of frame `first` up to frame `last`."""
    held = points.copy()
    held[first : last + 1, column] = points[first, column]
    return held


@pytest.mark.parametrize("first, last", [(20, 25), (20, 22), (50, 59)])
def test_a_held_value_is_a_gap(first, last):
    expected = np.zeros((FRAMES, 6), bool)
    expected[first + 1 : last + 1, 2] = True
    np.testing.assert_array_equal(held_points(frozen(moving(), 2, first, last)), expected)


@pytest.mark.parametrize("step", [0.001, 0.1, 1.0])
def test_in_coarse_numbers_the_leap_tells(step):
    points = (frozen(moving(), 2, 20, 25) / step).round() * step
    assert np.argwhere(held_points(points)).tolist() == [[t, 2] for t in range(21, 26)]


def test_a_long_gap_in_a_motion_that_comes_back():
    turn = np.arange(FRAMES) / FRAMES * 4 * np.pi
    points = moving()
    points[:, 2] = single(400 * np.stack([np.sin(turn), np.cos(turn), turn / 9], axis=-1))
    held = held_points(frozen(points, 2, 10, 45))
    assert np.flatnonzero(held[:, 2]).tolist() == list(range(11, 46)) and held.sum() == 35


def single(points):
    return points.astype(np.float32).astype(float)


def test_a_point_at_rest_in_coarse_numbers_is_no_gap():
    points = moving(speed=3.0)
    points[:, 2] = points[0, 2] + np.linspace(0, 2, FRAMES)[:, None] ** 2
    assert not held_points((points / 0.1).round() * 0.1).any()


@pytest.mark.parametrize("first, last", [(20, 25), (0, 5)])
def test_a_value_may_be_held_from_behind(first, last):
    expected = np.zeros((FRAMES, 6), bool)
    expected[first:last, 2] = True
    points = moving()
    points[first:last, 2] = points[last, 2]
    np.testing.assert_array_equal(held_points(points), expected)


@pytest.mark.parametrize(
    "points",
    [
        frozen(moving(), 2, 20, 21),
        np.repeat(moving()[:20], 3, axis=0),
        moving().round(0),
        np.concatenate([moving(), np.full((FRAMES, 1, 3), 40.0)], axis=1),
        frozen(moving(speed=0.0, noise=0.05), 2, 20, 25),
        moving()[:2],
    ],
    ids=["two frames may be chance", "all stand still", "whole millimetres", "never moves", "lost nothing", "short"],
)
def test_what_is_no_gap(points):
    assert not held_points(points).any()


def test_a_reader_says_it_and_can_be_told_not_to(tmp_path):
    points = frozen(moving(), 2, 20, 25)
    io.write_c3d(Recording(points, tuple("ABCDEF"), 60.0), tmp_path / "a.c3d")
    found = io.read(tmp_path / "a.c3d")
    assert np.argwhere(~found.present).tolist() == [[t, 2] for t in range(21, 26)]
    assert found.notes[0].startswith("5 points keep their coordinates to the last bit")
    told = io.read(tmp_path / "a.c3d", frozen_gaps=False)
    np.testing.assert_array_equal(told.points, points)
    assert not told.notes


@pytest.mark.parametrize("name", ["a.c3d", "a.trc"])
def test_a_result_keeps_every_cell(tmp_path, name):
    points = frozen(moving(), 2, 20, 25).round(3)
    if name == "a.c3d":
        io.write_c3d(Recording(points, tuple("ABCDEF"), 60.0), tmp_path / name)
    else:
        write_trc(points, tmp_path / name)
    recording = io.read(tmp_path / name)
    assert (~recording.present).sum() == 5
    io.write_labelled(make_labelling(recording, list("ABCDEF")), tmp_path / f"out{name[1:]}")
    back = io.read(tmp_path / f"out{name[1:]}", frozen_gaps=False)
    assert back.labels[:6] == tuple("ABCDEF") and back.points.shape[1] == 7
    assert np.flatnonzero(back.present[:, 6]).tolist() == [21, 22, 23, 24, 25]
    np.testing.assert_allclose(back.points[21:26, 6], points[21:26, 2], atol=1e-4)
    assert not back.present[21:26, 2].any()


def write_trc(points, path):
    names = "\t".join(f"{name}\t\t" for name in "ABCDEF")
    rows = [f"{t + 1}\t{t / 60:.3f}\t" + "\t".join(f"{v:.3f}" for v in frame.ravel()) for t, frame in enumerate(points)]
    head = ["PathFileType\t4\t(X/Y/Z)\ta.trc", "DataRate\tNumFrames\tNumMarkers\tUnits", f"60\t{len(points)}\t6\tmm"]
    path.write_text("\n".join([*head, f"Frame#\tTime\t{names}", "\t\tX1\tY1\tZ1", "", *rows]) + "\n")
