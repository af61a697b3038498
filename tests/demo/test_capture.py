"""The demo's pieces, with a stand-in for the matcher that knows the truth; and its picture."""

import sys
import types

import numpy as np
import pytest

from dshpm_jax import io
from dshpm_jax._demo import capture as demo
from dshpm_jax._labelling import Labelling, Reason
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH
from dshpm_jax.report._figures import figures_png
from dshpm_jax.report._looks import upward
from dshpm_jax.synthesis import person

PNG = b"\x89PNG"


@pytest.fixture(scope="module")
def capture():
    return demo._capture()


@pytest.fixture(scope="module")
def labelled(capture):
    """What a matcher would give that makes no mistake."""
    tracks = from_columns(capture.recording.points, capture.recording.rate)
    truth = capture.truth.numbered_by(capture.model.markers)
    identity = truth[tracks.start, tracks.column[tracks.start, tracks.slot]]
    reason = tuple(Reason.MATCHED if k != NO_MATCH else Reason.OUTSIDE for k in identity)
    return Labelling(capture.recording, capture.model, tracks, identity, np.ones(len(tracks)), reason)


@pytest.fixture
def knowing_matcher(monkeypatch, labelled):
    monkeypatch.setitem(sys.modules, "dshpm_jax._label", types.SimpleNamespace(label=lambda *_: labelled))


def test_the_capture_is_what_it_says(capture):
    assert capture.model.num_markers == 34 and len(capture.model.segments) == 15
    named = (capture.truth.identities != NO_MATCH).sum()
    assert named == pytest.approx(0.9 * 34 * 600, rel=0.01)
    assert capture.recording.present.sum() - named == pytest.approx(0.1 * 34 * 600, rel=0.01)


def test_the_demo_writes_what_it_names(knowing_matcher, capture, tmp_path, capsys):
    assert demo.run(tmp_path / "out") == 0
    said = capsys.readouterr().out
    assert said.count("100.00%") == 4
    assert all(label in said for label in capture.model.markers)
    assert max(map(len, said.splitlines()[:-1])) <= 88  # the last one names a folder
    assert io.read(tmp_path / "out" / "unlabelled.c3d").points.shape == capture.recording.points.shape
    assert io.read(tmp_path / "out" / "labelled.c3d").labels[:34] == capture.model.markers
    assert io.read_model(tmp_path / "out" / "model.json").markers == capture.model.markers
    assert (tmp_path / "out" / "figures.png").read_bytes().startswith(PNG)


def test_the_demo_overwrites_nothing(tmp_path, capsys):
    (tmp_path / "mine.txt").write_text("precious")
    assert demo.run(tmp_path) == 1
    assert "give another folder" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]


def test_without_matplotlib_the_picture_is_left_out(knowing_matcher, monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert demo.run(tmp_path / "out") == 0
    assert "dshpm-jax[pictures]" in capsys.readouterr().err
    assert not (tmp_path / "out" / "figures.png").exists()


def test_a_picture_of_chosen_frames(labelled, tmp_path):
    figures_png(labelled, tmp_path / "a.png", frames=[0, 599])
    assert (tmp_path / "a.png").read_bytes().startswith(PNG)
    with pytest.raises(ValueError, match="frames 0 to 599"):
        figures_png(labelled, tmp_path / "b.png", frames=[600])


def test_a_picture_where_nothing_was_found(labelled, tmp_path):
    nobody = Labelling(
        labelled.recording,
        labelled.model,
        labelled.trajectories,
        np.full_like(labelled.identity, NO_MATCH),
        labelled.confidence,
        labelled.reason,
    )
    figures_png(nobody, tmp_path / "a.png", frames=[10])
    assert (tmp_path / "a.png").read_bytes().startswith(PNG)


@pytest.mark.parametrize("activity", ["walking", "running", "freeform"])
@pytest.mark.parametrize("turned", [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_the_vertical_is_found(activity, turned):
    points = person(34, activity, 300).recording.points[::50, :, list(turned)]
    np.testing.assert_array_equal(upward(list(points)), np.eye(3)[turned.index(2)])
