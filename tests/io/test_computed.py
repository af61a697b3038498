"""Points that a model computed are left out, by how they move, by their marks and by their names; and it is said."""

import numpy as np
import pytest
from making import make_labelling
from scipy.spatial.transform import Rotation

from dshpm_jax import Recording, io
from dshpm_jax.io._computed import computed_points
from dshpm_jax.io._known_outputs import known_outputs

FRAMES = 90
NAMES = ("LASI", "RASI", "LKNE", "RKNE", "LANK", "RANK", "LTOE", "RTOE")


def markers(seed=2):
    rng = np.random.default_rng(seed)
    t = np.arange(FRAMES)[:, None, None] / 30
    sway = 200 * np.sin(2 * np.pi * (0.5 * t + rng.random((1, 8, 3)))) + rng.normal(0, 0.1, (FRAMES, 8, 3))
    return single(rng.uniform(-800, 800, (1, 8, 3)) + sway)


def single(points):
    return points.astype(np.float32).astype(float)


def axes(points, length=150.0):
    """Origin and ends of a frame of three markers."""
    x = points[:, 1] - points[:, 0]
    z = np.cross(x, points[:, 2] - points[:, 0])
    frame = [x, np.cross(z, x), z]
    ends = [points[:, 0] + length * axis / np.linalg.norm(axis, axis=-1, keepdims=True) for axis in frame]
    return single(np.stack([points[:, 0], *ends], axis=1))


def found(more):
    points = np.concatenate([markers(), more], axis=1)
    return (np.flatnonzero(computed_points(points)) - 8).tolist()


def test_measured_points_are_none():
    assert not computed_points(markers()).any()


def test_a_mixture_of_others():
    p = markers()
    middle, third = (p[:, 0] + p[:, 1]) / 2, p[:, 2] / 3 + 2 * p[:, 3] / 3
    four = p[:, 4:8].mean(1)
    assert found(single(np.stack([middle, third, four], axis=1))) == [0, 1, 2]


def test_what_only_nearly_is_a_mixture_stays():
    p = markers()
    noise = np.random.default_rng(0).normal(0, 0.1, (FRAMES, 1, 3))
    beyond = 2 * p[:, 1:2] - p[:, :1]  # as likely the outer of three is measured
    assert found(single((p[:, :1] + p[:, 1:2]) / 2 + noise)) == []
    assert found(single(np.concatenate([beyond], axis=1))) == [-7]


def test_axes_of_a_segment_and_copies():
    """The origin is a copy of a marker; the ends keep their distances to it and to each other."""
    assert found(axes(markers())) == [0, 1, 2, 3]


def test_a_solved_rigid_body_is_measured():
    rng = np.random.default_rng(5)
    turns = Rotation.from_rotvec(np.cumsum(rng.normal(0, 0.1, (FRAMES, 3)), axis=0)).as_matrix()
    body = np.einsum("tij,mj->tmi", turns, rng.uniform(-100, 100, (7, 3))) + np.arange(FRAMES)[:, None, None]
    assert found(single(body)) == []


def test_a_capture_at_rest_tells_nothing():
    still = np.repeat(markers()[:1], FRAMES, axis=0)
    frame = axes(still)
    assert not computed_points(np.concatenate([still, frame[:, 1:]], axis=1)).any()


@pytest.mark.parametrize(
    "names, expected",
    [
        (["LHJC", "R_KJC", "LAJC", "R_HJC_reg", "HipCenter", "V_Mid_ASIS", "CentreOfMass"], [0, 1, 2, 3, 4, 5, 6]),
        (["PELO", "PELA", "PELL", "PELP", "PELX"], [0, 1, 2, 3]),
        ([f"LFOF{k}" for k in range(4)] + ["LTIB1", "RPROXFF", "LD1M0", "LD1M", "LHLX"], [0, 1, 2, 3, 4, 5, 6]),
        (["LTIB1", "LTIB2", "LTIB3", "LTIB", "LFOF1", "V_Sacral", "V.Sacral", "KNEE", "CLAV", "*12"], []),
    ],
)
def test_names_that_models_give(names, expected):
    assert sorted(known_outputs(names)) == expected


def with_middle(tmp_path):
    p = markers()
    points = np.concatenate([single((p[:, :1] + p[:, 1:2]) / 2), p], axis=1)
    io.write_c3d(Recording(points, ("PELC", *NAMES), 30.0), tmp_path / "a.c3d")
    return points


def test_readers_leave_them_out_and_results_keep_them(tmp_path):
    points = with_middle(tmp_path)
    recording = io.read(tmp_path / "a.c3d")
    assert recording.labels == NAMES and recording.columns == tuple(range(1, 9))
    assert recording.notes == ("left out, as computed from markers: PELC (--drop '!NAME' keeps one)",)
    io.write_labelled(make_labelling(recording, list(NAMES)), tmp_path / "out.c3d")
    back = io.read(tmp_path / "out.c3d", drop=["!PELC"])
    assert back.labels == (*NAMES, "PELC")
    np.testing.assert_array_equal(back.points[:, 8], points[:, 0])


def test_columns_are_left_out_and_kept_as_one_says(tmp_path):
    with_middle(tmp_path)
    read = lambda *drop: io.read(tmp_path / "a.c3d", drop=drop)  # noqa: E731
    assert read("!PELC").labels == ("PELC", *NAMES) and not read("!PELC").notes
    assert read("?TOE", "!LTOE").labels == tuple(name for name in NAMES if name != "RTOE")
    assert read("#2").labels == NAMES[1:] and read("#2").notes[0] == "left out, as asked: LASI"
    with pytest.raises(io.ReadError, match="all its points are left out"):
        read("*")


def test_a_point_without_residual_among_others_that_have_one(tmp_path):
    file = io._c3d.fresh_layout(Recording(markers(), NAMES, 30.0))
    records = file.points.view("<f4").reshape(FRAMES, 8, 4)
    records[:, :7, 3] = 0.5
    records[3:9, 2, 3] = 0  # a gap that was filled
    io._c3d_format.write_layout(file, tmp_path / "a.c3d")
    assert io.read(tmp_path / "a.c3d").labels == NAMES[:7]
    records[..., 3] = 0
    io._c3d_format.write_layout(file, tmp_path / "b.c3d")
    assert io.read(tmp_path / "b.c3d").labels == NAMES


def test_a_file_of_computed_points_is_meant_so(tmp_path):
    io.write_c3d(Recording(markers(), tuple(f"{s}{j}JC" for s in "LR" for j in "HKAE"), 30.0), tmp_path / "a.c3d")
    assert len(io.read(tmp_path / "a.c3d").labels) == 8


@pytest.mark.parametrize("name", ["a.trc"])
def test_text_keeps_left_out_columns_and_their_names(tmp_path, name):
    head = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n100\t2\t3\tmm\n"
    names = "Frame#\tTime\tNick:LHJC\t\t\tNick:LASI\t\t\tNick:RASI\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3\n\n"
    rows = "1\t0\t1\t2\t3\t4\t5\t6\t7\t8\t9\n2\t0.01\t1.5\t2\t3\t4.5\t5\t6\t7.5\t8\t9\n"
    (tmp_path / name).write_text(head + names + rows)
    recording = io.read(tmp_path / name)
    assert recording.labels == ("LASI", "RASI") and recording.columns == (1, 2)
    io.write_labelled(make_labelling(recording, ["RASI", "LASI"]), tmp_path / "out.trc")
    lines = (tmp_path / "out.trc").read_text().splitlines()
    assert lines[3].split("\t")[2::3] == ["Nick:RASI", "Nick:LASI", "Nick:LHJC"]
    assert lines[6].split("\t")[2:] == ["7", "8", "9", "4", "5", "6", "1", "2", "3"]
