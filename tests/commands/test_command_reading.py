"""What commands say about doubtful recordings, what they pass over, and which columns people leave out."""

import subprocess
import sys

import numpy as np
import pytest
from commands import command
from making import make_recording

from dshpm_jax import Recording, io
from dshpm_jax.io._c3d import fresh_layout
from dshpm_jax.io._c3d_format import write_layout


def frozen():
    """A recording of which the second column is held for five frames."""
    rng = np.random.default_rng(0)
    points = rng.uniform(-900, 900, (1, 4, 3)) + np.cumsum(rng.normal(4, 1, (40, 4, 3)), axis=0)
    points[11:16, 1] = points[10, 1]
    return Recording(points.astype(np.float32).astype(float), ("LASI", "RASI", "SACR", "*4"), 100.0)


def muscles(path):
    """A trial of analog samples alone."""
    file = fresh_layout(Recording(np.ones((5, 0, 3)), (), 100.0))
    file.analog = np.ones((5, 8), np.uint8)
    write_layout(file, path)


@pytest.mark.parametrize("order", ["label", "model"])
def test_notes_are_said_once(folder, capsys, labeller, order):
    io.write_c3d(frozen(), folder / "frozen.c3d")
    out = "out" if order == "label" else "new.json"
    status, _, err = command(capsys, order, "frozen.c3d", "-o", out)
    assert status == 0 and err.count("\n") == 1 and "frozen.c3d: 5 points keep their coordinates" in err
    assert command(capsys, order, "frozen.c3d", "-o", out, "--keep-frozen")[2] == ""


def test_check_and_reconstruct_say_them_too(folder, capsys):
    io.write_c3d(frozen(), folder / "frozen.c3d")
    assert command(capsys, "model", "frozen.c3d", "-o", "new.json")[0] == 0
    for order in (["check", "frozen.c3d"], ["reconstruct", "frozen.c3d", "-o", "out"]):
        _, _, err = command(capsys, *order, "--model", "new.json")
        assert err.count("5 points keep their coordinates") == 1


def test_a_trial_without_points_is_passed_over(folder, capsys, labeller):
    muscles(folder / "emg.c3d")
    status, out, err = command(capsys, "label", "emg.c3d", "walk.c3d", "-o", "out")
    assert status == 0 and "emg.c3d: it holds analog samples alone, no points" in err and err.count("\n") == 1
    assert "1 of 2 recordings labelled, 1 passed over" in out
    assert not list((folder / "out").glob("emg*"))
    rows = (folder / "out" / "summary.csv").read_text()
    assert "passed over" in rows
    assert command(capsys, "model", "emg.c3d", "-o", "new.json")[0] == 1


def test_columns_to_leave_out(folder, capsys, labeller):
    io.write_c3d(make_recording(labels=("LASI", "RASI", "SACR", "HEAD")), folder / "four.c3d")
    status, _, err = command(capsys, "model", "four.c3d", "-o", "new.json", "--drop", "HE*", "--drop", "#2")
    assert status == 0 and "four.c3d: left out, as asked: RASI, HEAD" in err
    assert io.read_model(folder / "new.json").markers == ("LASI", "SACR")
    assert command(capsys, "label", "four.c3d", "-o", "out", "--drop", "HEAD")[0] == 0
    assert io.read(folder / "out" / "four.c3d").labels[-1] == "HEAD"
    (folder / "s.toml").write_text('drop = ["HEAD"]\nfrozen_gaps = false')
    assert command(capsys, "label", "four.c3d", "-o", "out", "--settings", "s.toml", "--force")[0] == 0
    settings = io.read_sidecar_head(folder / "out" / "four.labels.json")["settings"]
    assert settings["drop"] == ["HEAD"] and settings["frozen_gaps"] is False


def test_columns_that_the_model_has_are_not_left_out(folder, capsys, labeller):
    """A model may be older than the reader's opinion of a name."""
    io.write_c3d(make_recording(labels=("LASI", "RASI", "SACR", "LHJC")), folder / "joints.c3d")
    status, _, err = command(capsys, "model", "joints.c3d", "-o", "with.json", "--drop", "!LHJC")
    assert status == 0 and not err and "LHJC" in io.read_model(folder / "with.json").markers
    for model, said in (("with.json", False), ("model.json", True)):
        _, _, err = command(capsys, "label", "joints.c3d", "-o", model[:4], "--model", model)
        assert ("left out, as computed from markers: LHJC" in err) is said


def test_columns_of_one_name(folder, capsys):
    recording = make_recording(30, labels=("LASI", "RASI", "SACR", "SACR"))
    recording.points[:15, 3] = recording.points[15:, 2] = np.nan
    io.write_c3d(recording, folder / "turns.c3d")
    status, _, err = command(capsys, "model", "turns.c3d", "-o", "new.json")
    assert status == 0 and "turns.c3d: columns 3 and 4 are both named 'SACR' and take turns: joined" in err
    assert io.read_model(folder / "new.json").markers == ("LASI", "RASI", "SACR")
    status, _, err = command(capsys, "reconstruct", "turns.c3d", "-o", "out", "--model", "new.json")
    assert status == 1 and "columns 3 and 4 are both named 'SACR'" in err


def test_a_reader_of_our_lines_may_leave(folder):
    """As `head` does."""
    script = "import sys; from dshpm_jax.__main__ import main; sys.exit(main(['model', 'walk.c3d', '-o', 'new.json']))"
    process = subprocess.Popen(
        [sys.executable, "-c", script], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None and process.stderr is not None
    process.stdout.close()
    with process.stderr:
        assert process.wait(120) == 141 and process.stderr.read() == ""


def test_a_file_of_markers_goes_with_a_model_of_opensim(folder, capsys):
    status, _, err = command(capsys, "model", "walk.c3d", "-o", "new.json", "--markers", "set.xml")
    assert status == 2 and "goes with an .osim file" in err
    (folder / "leg.osim").write_text("<OpenSimDocument />")
    status, _, err = command(capsys, "model", "leg.osim", "-o", "new.json", "--markers", "set.xml")
    assert status == 1 and "set.xml: cannot be read" in err
