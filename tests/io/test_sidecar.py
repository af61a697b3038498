"""What the sidecar says about each trajectory."""

import json
from dataclasses import replace

import numpy as np
from making import make_labelling, make_recording

from dshpm_jax import Recording, io
from dshpm_jax._types import NO_MATCH


def test_a_row_for_each_trajectory(tmp_path):
    recording = make_recording()
    labelling = make_labelling(recording, ["SACR", "LASI"])
    io.write_sidecar(labelling, tmp_path / "a.labels.json", {"settings": {"method": "full"}})
    found = json.loads((tmp_path / "a.labels.json").read_text())
    assert found["markers"] == ["SACR", "LASI"] and found["settings"] == {"method": "full"}
    assert found["stats"] == {"svd_count": 12} and found["frames"] == 20 and found["source"] is None
    assert len(found["trajectories"]) == len(labelling.trajectories)
    seen = np.zeros(recording.present.shape, int)
    for row in found["trajectories"]:
        first, last = row["frames"]
        seen[first : last + 1, row["column"]] += 1
        name = recording.labels[row["column"]]
        assert row["label"] == (name if name in ("SACR", "LASI") else None)
        assert row.get("was") == (None if name == "*4" else name)
        assert row["confidence"] == 0.875 and row["reason"]
    np.testing.assert_array_equal(seen, recording.present)


def test_notes_of_the_reader(tmp_path):
    recording = replace(make_recording(), notes=("it is odd",))
    io.write_sidecar(make_labelling(recording, ["LASI"]), tmp_path / "a.json")
    assert json.loads((tmp_path / "a.json").read_text())["notes"] == ["it is odd"]
    io.write_sidecar(make_labelling(make_recording(), ["LASI"]), tmp_path / "b.json")
    assert "notes" not in json.loads((tmp_path / "b.json").read_text())


def test_columns_of_raw_points(tmp_path):
    recording = Recording(np.ones((6, 2, 3)), ("", ""), 100.0, columns=(3, 7))
    links = np.tile([0, 1], (6, 1))
    links[2] = [1, 0]
    links[5] = NO_MATCH
    io.write_sidecar(make_labelling(recording, ["A"], links), tmp_path / "a.json")
    rows = json.loads((tmp_path / "a.json").read_text())["trajectories"]
    columns = sorted(row["columns"] for row in rows)
    assert columns == [[[3, 0, 2], [7, 3, 5]], [[7, 0, 2], [3, 3, 5]]]
    assert all(row["column"] is None for row in rows)


def test_the_head_is_read_back(tmp_path):
    io.write_sidecar(make_labelling(make_recording(), ["LASI"]), tmp_path / "a.json", {"hashes": {"sha256": "x"}})
    head = io.read_sidecar_head(tmp_path / "a.json")
    assert head is not None and head["hashes"] == {"sha256": "x"}
    (tmp_path / "b.json").write_text('{"format": "something else"}')
    assert io.read_sidecar_head(tmp_path / "b.json") is None
    assert io.read_sidecar_head(tmp_path / "nowhere.json") is None


def test_read_back_with_and_without_column_runs(tmp_path):
    name = '"columns": [[1, 2, 3]], '
    recording = Recording(np.ones((6, 2, 3)), (name, "B"), 100.0)
    links = np.tile([0, 1], (6, 1))
    links[2], links[5] = [1, 0], NO_MATCH
    io.write_sidecar(make_labelling(recording, [name], links), tmp_path / "a.json")
    whole, short = io.read_sidecar(tmp_path / "a.json"), io.read_sidecar(tmp_path / "a.json", column_runs=False)
    assert whole is not None and short is not None
    assert [row.pop("columns") for row in whole["trajectories"]] == [[[0, 0, 2], [1, 3, 5]], [[1, 0, 2], [0, 3, 5]]]
    assert short == whole and short["markers"] == [name]
