"""`models`: a model in every subject's folder, nothing overwritten silently, and a reason for what is not used."""

import subprocess
import sys
from pathlib import Path

import pytest
from commands import command
from making import make_recording

from dshpm_jax import io

MARKERS = ["LASI", "RASI", "SACR"]


@pytest.fixture
def captures(folder):
    """Two subjects, a folder without labels, a damaged file and results."""
    for name in ("anna", "ben", "duet", "out"):
        (folder / "captures" / name).mkdir(parents=True)
    io.write_c3d(make_recording(60, MARKERS), folder / "captures" / "anna" / "rom.c3d")
    io.write_c3d(make_recording(60, ["*1", "*2", "*3"]), folder / "captures" / "anna" / "walk.c3d")
    io.write_c3d(make_recording(60, MARKERS, seed=1), folder / "captures" / "ben" / "rom.c3d")
    (folder / "captures" / "ben" / "bad.c3d").write_bytes(b"")
    io.write_c3d(make_recording(60, ["*1", "*2"]), folder / "captures" / "duet" / "duet.c3d")
    io.write_c3d(make_recording(60, MARKERS), folder / "captures" / "out" / "walk.c3d")
    (folder / "captures" / "out" / "manifest.jsonl").write_text("")
    return folder / "captures"


def models(captures: Path) -> dict[str, bytes]:
    return {path.parent.name: path.read_bytes() for path in captures.rglob("model.json")}


def test_models(captures, capsys):
    status, out, err = command(capsys, "models", "captures")
    assert (status, err) == (0, "") and models(captures).keys() == {"anna", "ben"}
    assert [line.partition(";")[0] for line in out.splitlines()] == [
        "captures/anna/rom.c3d: used",
        "captures/anna: 1 recording has no label: walk.c3d",
        "captures/anna/model.json: 3 markers in 1 segments",
        "captures/ben/rom.c3d: used",
        "captures/ben/bad.c3d: not used, the file is empty",
        "captures/ben/model.json: 3 markers in 1 segments",
        "captures/duet: 1 recording has no label: duet.c3d",
        "2 models made or kept",
    ]
    assert io.read_model(captures / "ben" / "model.json").sources == ("rom.c3d",)


def test_a_dry_run_writes_nothing_and_needs_no_jax(captures, capsys):
    code = (
        "import sys\nfrom dshpm_jax.__main__ import main\n"
        "assert main(['models', 'captures', '--dry-run']) == 0\nsys.exit('jax' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and not models(captures)
    assert "captures/anna/model.json: would be made" in done.stdout and done.stdout.endswith(
        "2 models would be made or kept\n"
    )


def test_models_that_are_there_are_kept_unless_forced(captures, capsys):
    command(capsys, "models", "captures")
    first = models(captures)
    io.write_c3d(make_recording(80, MARKERS, seed=2), captures / "anna" / "rom.c3d")
    status, out, err = command(capsys, "models", "captures")
    assert (status, err) == (0, "") and models(captures) == first
    assert "captures/anna/model.json: is there, kept; --force makes it again" in out
    assert "would be replaced" in command(capsys, "models", "captures", "--force", "--dry-run")[1]
    assert models(captures) == first
    assert command(capsys, "models", "captures", "--force")[0] == 0
    assert models(captures)["ben"] == first["ben"] and models(captures)["anna"] != first["anna"]


def test_what_is_no_model_is_never_overwritten(captures, capsys):
    (captures / "anna" / "model.json").write_text('{"of": "somebody else"}')
    status, out, err = command(capsys, "models", "captures", "--force")
    assert status == 1 and "captures/anna/model.json: is there and no marker model, not overwritten" in err
    assert models(captures)["anna"] == b'{"of": "somebody else"}' and "ben" in models(captures)
    assert out.endswith("1 model made or kept, 1 could not be made\n")


def test_one_that_fails_harms_no_other(captures, capsys):
    (captures / "segments.toml").write_text('[hip]\nmarkers = ["LASI", "RASI", "SACR"]\n')
    io.write_c3d(make_recording(60, ["A", "B", "C"]), captures / "anna" / "rom.c3d")
    status, _, err = command(capsys, "models", "captures", "--segments", captures / "segments.toml")
    assert status == 1 and "names LASI" in err and err.count("\n") == 1 and models(captures).keys() == {"ben"}


def test_an_archive_without_labels(captures, capsys):
    status, out, err = command(capsys, "models", captures / "duet")
    assert status == 1 and out.endswith("0 models made or kept\n") and not models(captures)


@pytest.mark.parametrize("arguments", [["nowhere"], ["walk.c3d"], [], [".", "--template", "octopus"]])
def test_wrong_usage_of_models(folder, capsys, arguments):
    before = (folder / "model.json").read_bytes()
    status, _, err = command(capsys, "models", *arguments)
    assert status == 2 and err and (folder / "model.json").read_bytes() == before


def test_labels_are_compared_where_there_are_several_recordings(captures, capsys, monkeypatch):
    def compare_labels(choice):
        wrong = choice.used.pop().source
        choice.left_out[wrong] = "the model of the others says: LASI, frames 1-60, should be RASI"

    monkeypatch.setattr("dshpm_jax._model_choice.compare_labels", compare_labels)
    io.write_c3d(make_recording(60, MARKERS, seed=3), captures / "anna" / "run.c3d")
    out = command(capsys, "models", "captures")[1]
    assert "captures/anna: comparing the labels of 2 recordings" in out and "captures/ben: comparing" not in out
    assert "captures/anna/run.c3d: not used, the model of the others says: LASI" in out
    assert len(io.read_model(captures / "anna" / "model.json").sources) == 1
    out = command(capsys, "models", "captures", "--force", "--no-check")[1]
    assert "comparing" not in out and len(io.read_model(captures / "anna" / "model.json").sources) == 2
