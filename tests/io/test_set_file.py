"""A marker set is a file like a model, and what is wrong with one is said."""

import json

import numpy as np
import pytest

from dshpm_jax import MarkerSet, SubjectModel, io
from dshpm_jax.synthesis import person


@pytest.fixture(scope="module")
def markers() -> MarkerSet:
    return MarkerSet.from_subjects({f"s{k}": [person(34, frames=40, subject=k, seed=k).recording] for k in (1, 2, 3)})


def test_a_set_comes_back_as_it_was_written(markers, tmp_path):
    io.write_marker_set(markers, tmp_path / "set.json")
    again = io.read_marker_set(tmp_path / "set.json")
    assert again.markers == markers.markers and again.subjects == markers.subjects and again.odd == markers.odd
    np.testing.assert_allclose(again.mean_log, markers.mean_log, atol=1e-4)
    np.testing.assert_allclose(again.components, markers.components, atol=1e-4)
    assert [four.markers for four in again.fours] == [four.markers for four in markers.fours]
    assert json.loads((tmp_path / "set.json").read_text())["kind"] == "marker set"
    assert io.is_model(tmp_path / "set.json") and io.is_marker_set(tmp_path / "set.json")


def test_each_reader_says_what_the_file_is(markers, tmp_path):
    io.write_marker_set(markers, tmp_path / "set.json")
    io.write_model(markers.model, tmp_path / "model.json", {"by": "a test"})
    with pytest.raises(io.ReadError, match="is a marker set, the model of nobody in particular"):
        io.read_model(tmp_path / "set.json")
    with pytest.raises(io.ReadError, match="is a subject's model and no marker set"):
        io.read_marker_set(tmp_path / "model.json")
    assert isinstance(io.read_model_or_set(tmp_path / "model.json"), SubjectModel)
    assert io.made_from(tmp_path / "model.json") == {"by": "a test"}
    assert io.made_from(tmp_path / "set.json") is None and io.made_from(tmp_path / "none.json") is None


def test_a_set_of_one_subject_has_no_components_and_comes_back(markers, tmp_path):
    one = MarkerSet.from_subjects({"s1": [person(34, frames=40, subject=1, seed=1).recording]})
    io.write_marker_set(one, tmp_path / "set.json")
    assert io.read_marker_set(tmp_path / "set.json").components.shape == (0, 34, 34)


@pytest.mark.parametrize(
    "entry, value, says",
    [
        ("version", 99, "has version 99, this program knows 3"),
        ("sizes", [0.0], "has 1 sizes for 3 subjects"),
        ("fours", [{"markers": [0, 1, 2, 99], "mean": 0.1, "sd": 0.1}], r"fours\[0\] does not name four markers"),
        ("worn", None, "worn is no table of numbers"),
        ("surplus", 1, "an unknown entry 'surplus'"),
    ],
)
def test_what_is_wrong_is_named(markers, tmp_path, entry, value, says):
    path = tmp_path / "set.json"
    io.write_marker_set(markers, path)
    path.write_text(json.dumps(json.loads(path.read_text()) | {entry: value}))
    with pytest.raises(io.ReadError, match=says):
        io.read_marker_set(path)
