"""Recordings: what their constructor takes, what they say of themselves, and columns by name."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from making import make_labelling, make_model, make_recording

from dshpm_jax import Recording
from dshpm_jax._recording import MILLIMETRES


@given(st.sampled_from(sorted(MILLIMETRES)), st.sampled_from(sorted(MILLIMETRES)), st.integers(0, 9))
def test_points_are_converted_from_the_unit_that_they_are_given_in(given_in, file_unit, seed):
    known = make_recording(seed=seed)
    found = Recording(known.points / MILLIMETRES[given_in], known.labels, 100.0, file_unit, points_unit=given_in)
    np.testing.assert_allclose(found.points, known.points, rtol=1e-12)
    assert found.unit == file_unit and found.points_unit == "mm"


@pytest.mark.parametrize("again", [lambda r: replace(r, rate=50.0), lambda r: r.frames(0), pickle.dumps])
def test_a_recording_is_converted_once(again):
    metres = Recording(np.ones((2, 1, 3)), ("A",), 100.0, points_unit="m")
    found = again(metres)
    found = pickle.loads(found) if isinstance(found, bytes) else found
    assert (found.points == 1000.0).all()


def test_points_that_need_no_conversion_are_not_copied():
    points = np.ones((2, 1, 3))
    assert Recording(points, ("A",), 100.0, "m").points is points


def test_an_unknown_unit_is_refused():
    with pytest.raises(ValueError, match="points_unit must be one of mm, cm, m, got 'inch'"):
        Recording(np.ones((2, 1, 3)), ("A",), 100.0, points_unit="inch")


def test_lists_do():
    found = Recording([[[1.0, 2, 3]]], ["A"], 100.0)  # pyright: ignore[reportArgumentType]
    assert found.points.shape == (1, 1, 3) and found.labels == ("A",)


def test_what_they_say_of_themselves():
    recording = make_recording(1200, ["A", "B", "*1"], source=Path("somewhere/walk.c3d"))
    assert repr(recording) == "Recording(1200 frames at 100 Hz, 2 of 3 columns named, from walk.c3d)"
    assert repr(replace(recording, source=None)) == "Recording(1200 frames at 100 Hz, 2 of 3 columns named)"
    model = make_model(["A", "B"])
    assert repr(model) == "SubjectModel(2 markers in 1 segments, from walk.c3d)"
    assert repr(replace(model, sources=())) == "SubjectModel(2 markers in 1 segments)"
    assert repr(replace(model, sources=tuple("abcd"))) == "SubjectModel(2 markers in 1 segments, from 4 recordings)"
    short = replace(recording.frames(0, 1), source=recording.source)
    labelling = make_labelling(short, ["A", "C"])
    tracks = len(labelling.trajectories)
    expected = f"Labelling(1 of {tracks} trajectories named, 1 of 2 markers found, of walk.c3d)"
    assert repr(labelling) == expected


def test_a_column_by_its_name():
    recording = make_recording(9, ["LKNE", "RKNE", "*4"])
    assert recording["RKNE"].shape == (9, 3)
    np.testing.assert_array_equal(recording["RKNE"], recording.points[:, 1])
    np.testing.assert_array_equal(recording["*4"], recording.points[:, 2])
    assert "LKNE" in recording and "LANK" not in recording and 3 not in recording


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("lkne", "no column is called 'lkne'; did you mean LKNE?"),
        ("anna:LKNE", "no column is called 'anna:LKNE'; did you mean LKNE?"),
        ("LKN", "no column is called 'LKN'; did you mean LKNE"),
        ("zzz", "no column is called 'zzz'; there are LKNE, RKNE"),
        (3, "a column is asked for by its name, got 3"),
    ],
)
def test_a_name_that_is_not_there(asked, said):
    with pytest.raises(KeyError) as told:
        make_recording(9, ["LKNE", "RKNE", "*4"])[asked]
    assert said in str(told.value)


def test_columns_of_one_name_take_turns():
    points = np.full((4, 2, 3), np.nan)
    points[:2, 0], points[3:, 1] = 1.0, 2.0
    found = Recording(points, ("A", "A"), 100.0)["A"]
    np.testing.assert_array_equal(found[:, 0], [1.0, 1.0, np.nan, 2.0])
    points[0, 1] = 5.0
    with pytest.raises(ValueError, match="2 columns are called 'A' and seen together"):
        Recording(points, ("A", "A"), 100.0)["A"]


def test_a_name_in_brackets_makes_no_sequence():
    with pytest.raises(TypeError, match="not iterable"):
        list(make_recording(9))  # pyright: ignore[reportArgumentType]
