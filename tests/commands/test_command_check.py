"""`check` and `reconstruct`."""

import dataclasses
import json
import sys
from types import SimpleNamespace

import pytest
from commands import command
from making import make_recording

from dshpm_jax import io

MARKERS = ["LASI", "RASI", "SACR"]


@pytest.fixture
def checker(monkeypatch):
    """Stands in for the real one: finds that the first column is the second marker in the first two frames."""

    def check(recording, model, driver):
        if recording.num_frames == 9:
            return []
        return [SimpleNamespace(label="LASI", column=0, first=0, last=1, should_be="RASI", evidence=12.345)]

    monkeypatch.setitem(sys.modules, "dshpm_jax._check", SimpleNamespace(check=check))


def test_check(folder, capsys, checker):
    io.write_c3d(make_recording(9, MARKERS), folder / "sound.c3d")
    status, out, err = command(capsys, "check", "sound.c3d", "--model", "model.json")
    assert (status, out, err) == (0, "sound.c3d: no wrong label found\n", "")
    status, out, err = command(capsys, "check", "walk.c3d", "sound.c3d", "--model", "model.json", "--json", "f.json")
    assert status == 1 and err == ""
    assert out.splitlines()[0] == "walk.c3d: LASI, frames 1-2, should be RASI (evidence 12)"
    (row,) = json.loads((folder / "f.json").read_text())
    assert (row["frames"], row["file_frames"], row["should_be"]) == ([0, 1], [1, 2], "RASI")


def test_check_of_files_that_cannot_be(folder, capsys, checker):
    (folder / "bad.c3d").write_bytes(b"")
    status, out, err = command(capsys, "check", "bad.c3d", "walk.c3d", "--model", "model.json")
    assert status == 1 and "bad.c3d: the file is empty" in err and err.count("\n") == 1 and "walk.c3d: LASI" in out
    (folder / "other.json").write_text("{}")
    status, out, err = command(capsys, "check", "walk.c3d", "--model", "other.json")
    assert status == 1 and "this is no marker model" in err and err.count("\n") == 1


def test_another_unit_is_no_sound_label(folder, capsys, checker):
    walk = io.read(folder / "walk.c3d")
    io.write_c3d(dataclasses.replace(walk, points=walk.points / 1000.0), folder / "metres.c3d")
    status, out, err = command(capsys, "check", "metres.c3d", "--model", "model.json")
    assert (status, out) == (1, "") and err.count("\n") == 1
    assert "metres.c3d: no label could be confirmed, as its points are spread over" in err


def test_reconstruct(folder, capsys):
    (folder / "bad.c3d").write_bytes(b"")
    status, out, err = command(
        capsys, "reconstruct", "walk.c3d", "bad.c3d", "--model", "model.json", "-o", "out", "--fill"
    )
    assert status == 1 and "bad.c3d: the file is empty" in err and err.count("\n") == 1
    assert "walk.c3d: 60 frames, poses " in out and "points filled" in out
    assert io.read(folder / "out" / "walk.filled.c3d").num_frames == 60
    before = (folder / "out" / "walk.motion.npz").read_bytes()
    again = ["reconstruct", "walk.c3d", "--model", "model.json", "-o", "out"]
    status, _, err = command(capsys, *again)
    assert status == 1 and "walk.motion.npz: is there already" in err and err.count("\n") == 1
    assert (folder / "out" / "walk.motion.npz").read_bytes() == before
    assert command(capsys, *again, "--force")[0] == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ["reconstruct", "walk.c3d", "-o", "out"],
        ["reconstruct", "walk.c3d", "--model", "nowhere.json", "-o", "out"],
        ["reconstruct", "walk.c3d", "--model", "model.json", "-o", "model.json"],
        ["reconstruct", "walk.c3d", "sub/walk.c3d", "--model", "model.json", "-o", "out"],
    ],
)
def test_wrong_usage_of_reconstruct(folder, capsys, arguments):
    status, _, err = command(capsys, *arguments)
    assert status == 2 and err and not (folder / "out").exists()


def test_findings_overwrite_findings_only(folder, capsys, checker):
    model = (folder / "model.json").read_bytes()
    status, _, err = command(capsys, "check", "walk.c3d", "--model", "model.json", "--json", "model.json")
    assert status == 2 and "model.json: is there and holds no findings, not overwritten" in err
    assert (folder / "model.json").read_bytes() == model
    (folder / "f.json").write_text("[]\n")
    for _ in range(2):
        assert command(capsys, "check", "walk.c3d", "--model", "model.json", "--json", "f.json")[0] == 1
        assert len(json.loads((folder / "f.json").read_text())) == 1


def test_filled_points_for_opensim(folder, capsys):
    order = ["reconstruct", "walk.c3d", "--model", "model.json", "-o", "out", "--format", "trc", "--up", "y"]
    status, _, err = command(capsys, *order)
    assert status == 2 and "add --fill" in err
    assert command(capsys, *order, "--fill", "--unit", "m")[0] == 0
    turned, before = io.read(folder / "out" / "walk.filled.trc"), io.read(folder / "walk.c3d")
    assert turned.unit == "m" and turned.labels == before.labels
    x, y, z = before["LASI"].T
    assert abs(turned["LASI"].T - [x, z, -y]).max() < 1e-3
