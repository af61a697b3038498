"""Recordings to and from kineticstoolkit, which need not be installed: a stand-in has what its TimeSeries has."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from making import make_recording
from recordings import recordings

from dshpm_jax import Recording
from dshpm_jax._bridges.optional import distinct


class TimeSeries:
    def __init__(self, time=(), data=None, data_info=None):
        self.time, self.data, self.data_info = np.array(time), data or {}, data_info or {}


@given(recordings)
def test_there_and_back(recording):
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "kineticstoolkit", SimpleNamespace(TimeSeries=TimeSeries))
        series = recording.to_kineticstoolkit()
    assert all(values.shape == (recording.num_frames, 4) for values in series.data.values())
    found = Recording.from_kineticstoolkit(series)
    np.testing.assert_allclose(found.points, recording.points, rtol=1e-12)
    assert list(found.labels) == distinct(recording.labels)
    assert found.rate == pytest.approx(recording.rate, abs=1e-6) and found.unit == "m"


def test_kineticstoolkit_itself():
    toolkit = pytest.importorskip("kineticstoolkit")
    recording = make_recording(9, ["LKNE", "RKNE"])
    made = recording.to_kineticstoolkit()
    assert isinstance(made, toolkit.TimeSeries) and made.data_info["LKNE"]["Unit"] == "m"
    np.testing.assert_allclose(Recording.from_kineticstoolkit(made)["RKNE"], recording["RKNE"], rtol=1e-12)


def series(frames=5, **data_info):
    data = {"anna:LKNE": np.ones((frames, 4)), "_1": np.ones((frames, 4)), "force": np.ones(frames)}
    return TimeSeries(0.3 + np.arange(frames) / 50, data, data_info)


def test_its_points_are_metres_unless_it_says_otherwise():
    found = Recording.from_kineticstoolkit(series())
    assert found.labels == ("LKNE", "") and (found.points == 1000.0).all() and found.rate == 50.0
    known = {"anna:LKNE": {"Unit": "mm"}, "_1": {"Unit": "mm"}}
    assert (Recording.from_kineticstoolkit(series(**known)).points == 1.0).all()


def test_what_cannot_be_a_recording():
    with pytest.raises(ValueError, match="the unit of '_1' is 'deg', not one of mm, cm, m"):
        Recording.from_kineticstoolkit(series(_1={"Unit": "deg"}))
    with pytest.raises(ValueError, match="give the TimeSeries of the points"):
        Recording.from_kineticstoolkit(TimeSeries([0.0, 1.0], {"force": np.ones(2)}))
    with pytest.raises(ValueError, match="one frame tells no rate"):
        Recording.from_kineticstoolkit(series(1))
    assert Recording.from_kineticstoolkit(series(1), rate=50.0).rate == 50.0
    uneven = series()
    uneven.time[2] += 0.01
    with pytest.raises(ValueError, match="not evenly spaced"):
        Recording.from_kineticstoolkit(uneven)


def test_without_kineticstoolkit(monkeypatch):
    monkeypatch.setitem(sys.modules, "kineticstoolkit", None)
    with pytest.raises(ImportError, match="to_kineticstoolkit needs kineticstoolkit, which is not installed"):
        make_recording(9).to_kineticstoolkit()
