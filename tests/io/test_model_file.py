"""Models as JSON, and every kind of damage told in one line."""

import dataclasses
import json

import numpy as np
import pytest
from making import make_model

from dshpm_jax import io
from dshpm_jax._model import Neighbourhood, Segment, VirtualJoin
from dshpm_jax.io._fields import encode


def hand_and_arm():
    model = make_model(["A", "B", "C", "D", "E"])
    joint = VirtualJoin(np.array([1.0, 2.0, 3.0]), np.array([0.5, 0.0, -1.25]), 1.5)
    arm = Segment("arm", (0, 1, 2), np.arange(9.0).reshape(3, 3))
    hand = Segment("hand", (2, 3, 4), np.arange(9.0).reshape(3, 3), 0, (2,), joint, 0.2, 0.9)
    near = [Neighbourhood(((m + 1) % 5, (m + 3) % 5), np.eye(3), np.array([2.5, 4.0]), 1.25) for m in range(5)]
    return dataclasses.replace(model, segments=(arm, hand), neighbourhoods=tuple(near))


@pytest.mark.parametrize("model", [make_model(["LASI"]), make_model(["A", "B"]), hand_and_arm()])
def test_a_model_survives(tmp_path, model):
    io.write_model(model, tmp_path / "model.json")
    back = io.read_model(tmp_path / "model.json")
    assert encode(back) == encode(model)
    assert np.isnan(back.pair_spread[0, 0])
    assert io.is_model(tmp_path / "model.json")


def version_1(model) -> dict:
    """The entries of a file that version 1 wrote."""
    found = {"format": "dshpm-model", "version": 1} | encode(model)
    for near in found["neighbourhoods"]:
        near["softness"], near["spread"] = near.pop("distance_sd"), near.pop("marker_sd")
    tables = ("pair_low", "pair_high", "pair_frames")
    return found | dict.fromkeys(tables, [[0] * model.num_markers] * model.num_markers)


def test_a_file_of_version_1_is_read(tmp_path):
    (tmp_path / "old.json").write_text(json.dumps(version_1(hand_and_arm())))
    assert encode(io.read_model(tmp_path / "old.json")) == encode(hand_and_arm())


@pytest.mark.parametrize("near", [None, 3, [3], [{"softness": 2}]])
def test_a_damaged_file_of_version_1_is_told(tmp_path, near):
    check(tmp_path, json.dumps(version_1(hand_and_arm()) | {"neighbourhoods": near}), "neighbourhoods")


def test_lengths_are_rounded_and_rows_stay_in_one_line(tmp_path):
    model = dataclasses.replace(make_model(["A", "B"]), pair_mean=np.array([[0, 1 / 3], [1 / 3, 0]]))
    io.write_model(model, tmp_path / "model.json")
    assert "[0.3333, 0.0]" in (tmp_path / "model.json").read_text()
    np.testing.assert_allclose(io.read_model(tmp_path / "model.json").pair_mean, model.pair_mean, atol=1e-4)


def damaged(change):
    found = {"format": "dshpm-model", "version": 2} | encode(hand_and_arm())
    change(found)
    return found


DAMAGE = {
    "no marker model": lambda m: m.pop("format"),
    "has version 9": lambda m: m.update(version=9),
    "the model has no 'pair_mean'": lambda m: m.pop("pair_mean"),
    "unknown entry 'pair_meen'": lambda m: m.update(pair_meen=[]),
    "the model.markers is 'LASI'": lambda m: m.update(markers="LASI"),
    "the model.markers[1] is 3": lambda m: m["markers"].__setitem__(1, 3),
    "two markers with the name 'A'": lambda m: m["markers"].__setitem__(1, "A"),
    "the model.pair_mean has the shape (4, 5)": lambda m: m["pair_mean"].pop(),
    "the model.pair_spread is no table of numbers": lambda m: m["pair_spread"][0].pop(),
    "the model.pair_mean is not symmetric": lambda m: m["pair_mean"][0].__setitem__(1, 5.0),
    "the model.pair_spread holds negative": lambda m: [m["pair_spread"][a].__setitem__(1 - a, -5.0) for a in (0, 1)],
    "'arm' has no markers": lambda m: m["segments"][0].update(markers=[], shape=[]),
    "'arm' names a marker beyond": lambda m: m["segments"][0].update(markers=[0, 1, 9]),
    "'arm' does not list its markers in ascending": lambda m: m["segments"][0].update(markers=[0, 2, 1]),
    "'arm' has a shape with missing": lambda m: m["segments"][0]["shape"][0].__setitem__(0, None),
    "segments[0].shape has the shape (2, 3)": lambda m: m["segments"][0]["shape"].pop(),
    "'hand' has the parent 7": lambda m: m["segments"][1].update(parent=7),
    "form a circle": lambda m: m["segments"][0].update(parent=1),
    "'hand' joins its parent": lambda m: m["segments"][1].update(join=[3]),
    "'arm' needs a distortion_ratio between 0 and 10 and": lambda m: m["segments"][0].update(distortion_ratio=1e308),
    "'hand' needs a distortion_ratio": lambda m: m["segments"][1].update(matching_quantity=2),
    "virtual_join.spread is 'wide'": lambda m: m["segments"][1]["virtual_join"].update(spread="wide"),
    "has 1 neighbourhoods for 5": lambda m: m["neighbourhoods"].__setitem__(slice(1, None), []),
    "neighbourhoods[2] names a marker": lambda m: m["neighbourhoods"][2].update(markers=[0, 2]),
    "neighbourhoods[2].shape has the shape (2, 3), expected (3, 3)": lambda m: m["neighbourhoods"][2]["shape"].pop(),
    "neighbourhoods[0] holds missing": lambda m: m["neighbourhoods"][0].update(marker_sd=None),
    "neighbourhoods[1] has 9 markers, at most 8": lambda m: m["neighbourhoods"][1].update(
        markers=[0] * 9, shape=[[0, 0, 0]] * 10, distance_sd=[1] * 9
    ),
    "neighbourhoods[1] holds missing": lambda m: m["neighbourhoods"][1].update(distance_sd=[1e-300, 1.0]),
    "neighbourhoods[1] holds lengths of more than 1e+09": lambda m: m["neighbourhoods"][1].update(marker_sd=1e38),
    "the model.pair_mean holds lengths": lambda m: [m["pair_mean"][a].__setitem__(1 - a, 1e200) for a in (0, 1)],
    "'arm' holds lengths of more": lambda m: m["segments"][0]["shape"][0].__setitem__(0, -2e9),
    "'E' belongs to no segment": lambda m: m["segments"][1].update(markers=[2, 3], shape=[[0, 0, 0], [1, 0, 0]]),
}


@pytest.mark.parametrize("wrong", DAMAGE)
def test_damage(tmp_path, wrong):
    check(tmp_path, json.dumps(damaged(DAMAGE[wrong])), wrong)


@pytest.mark.parametrize(
    "content, wrong",
    [
        ("", "is empty"),
        ("{", "no JSON"),
        ("[]", "no marker model"),
        ("[" * 100_000, "no JSON"),  # deeper than the parser goes
        ('{"format": "dshpm-model", "version": 2, "' + "a" * 5000 + '": 0}', "unknown entry"),
    ],
)
def test_other_files(tmp_path, content, wrong):
    check(tmp_path, content, wrong)


def test_no_file(tmp_path):
    with pytest.raises(io.ReadError, match="cannot be read"):
        io.read_model(tmp_path / "nowhere.json")


def check(tmp_path, content: str, wrong: str):
    path = tmp_path / "model.json"
    path.write_text(content)
    with pytest.raises(io.ReadError) as caught:
        io.read_model(path)
    text = str(caught.value)
    assert wrong in text and text.startswith(f"{path}: ") and "\n" not in text and len(text) < len(str(path)) + 600
    assert not io.is_model(path) or json.loads(content)


def test_segments_file(tmp_path):
    path = tmp_path / "segments.toml"
    path.write_text('[arm]\nmarkers = ["A", "B"]\n[hand]\nmarkers = ["B", "C"]\nparent = "arm"\n')
    assert io.read_segments(path, "ABC") == {
        "arm": {"markers": ["A", "B"], "parent": None},
        "hand": {"markers": ["B", "C"], "parent": "arm"},
    }


@pytest.mark.parametrize(
    "content, wrong",
    [
        ("", "names no segments"),
        ("[arm", "is no TOML"),
        ("arm = " + "[" * 100_000, "is no TOML"),
        ("[arm]\n", "has no list of markers"),
        ('arm = ["A"]\n', "something else than markers"),
        ('[arm]\nmarkers = ["A", "X", "Y"]\n', "names X, Y, which the recordings do not have"),
        ('[arm]\nmarkers = ["A"]\nparent = "leg"\n', "has the parent 'leg'"),
    ],
)
def test_segments_files_that_are_wrong(tmp_path, content, wrong):
    path = tmp_path / "segments.toml"
    path.write_text(content)
    with pytest.raises(io.ReadError) as caught:
        io.read_segments(path, "ABC")
    assert wrong in str(caught.value) and "\n" not in str(caught.value)
