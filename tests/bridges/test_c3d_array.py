"""Recordings to and from ezc3d."""

import sys

import numpy as np
import pytest
from hypothesis import given
from making import make_recording
from recordings import recordings

from dshpm_jax import Recording, io
from dshpm_jax._bridges.optional import distinct

ezc3d = pytest.importorskip("ezc3d")


@given(recordings)
def test_there_and_back(recording):
    found = Recording.from_ezc3d(recording.to_ezc3d())
    np.testing.assert_allclose(found.points, recording.points, rtol=1e-12)
    assert list(found.labels) == distinct(recording.labels)
    assert (found.rate, found.unit) == (recording.rate, recording.unit)


def test_what_ezc3d_reads_is_what_we_read(tmp_path):
    names = [f"M{k}" for k in range(300)]  # more than one list of labels holds
    io.write_c3d(make_recording(9, [*names, "*1"], unit="m"), tmp_path / "a.c3d")
    ours, theirs = io.read(tmp_path / "a.c3d"), Recording.from_ezc3d(ezc3d.c3d(str(tmp_path / "a.c3d")))
    np.testing.assert_allclose(theirs.points, ours.points, rtol=1e-6)
    assert (theirs.labels, theirs.rate, theirs.unit) == (ours.labels, ours.rate, ours.unit)


def test_what_ezc3d_writes_is_what_it_was_given(tmp_path):
    recording = make_recording(9, ["LKNE", "RKNE", "*1"], unit="m")
    recording.to_ezc3d().write(str(tmp_path / "a.c3d"))
    found = io.read(tmp_path / "a.c3d")
    np.testing.assert_allclose(found.points, recording.points, rtol=1e-6, atol=1e-3)
    assert (found.labels, found.rate, found.unit) == (recording.labels, recording.rate, "m")


def made(points, **parameters):
    return {"data": {"points": points}, "parameters": {"POINT": {k: {"value": v} for k, v in parameters.items()}}}


def test_a_dictionary_does():
    points = np.ones((4, 2, 5))
    found = Recording.from_ezc3d(made(points, LABELS=["anna:LKNE"], RATE=np.array([100.0]), UNITS=["m"]))
    assert found.labels == ("LKNE", "") and found.points.shape == (5, 2, 3) and (found.points == 1000.0).all()


def test_what_cannot_be_a_recording():
    with pytest.raises(ValueError, match=r"the shape \(4, points, frames\), got \(5, 2\)"):
        Recording.from_ezc3d(made(np.ones((5, 2))))
    with pytest.raises(ValueError, match="rate"):
        Recording.from_ezc3d(made(np.ones((4, 2, 5))))
    with pytest.raises(ValueError, match="got 'furlong'"):
        Recording.from_ezc3d(made(np.ones((4, 2, 5)), RATE=[100.0], UNITS=["furlong"]))


def test_without_ezc3d(monkeypatch):
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    with pytest.raises(ImportError, match="to_ezc3d needs ezc3d, which is not installed; pip install ezc3d"):
        make_recording(9).to_ezc3d()
