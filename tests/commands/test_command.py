"""The command line: exit statuses, one line for each trouble, and never a traceback."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from commands import command
from making import make_recording

from dshpm_jax import Recording, io

MARKERS = ["LASI", "RASI", "SACR"]


def test_help_answers_without_jax():
    code = (
        "import sys\nfrom dshpm_jax.__main__ import main\n"
        "try:\n main(['label', '--help'])\nexcept SystemExit:\n sys.exit('jax' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and "--settings" in done.stdout


def test_a_trouble_is_told_once(folder):
    """A log that nobody set up must not repeat it."""
    order = [sys.executable, "-m", "dshpm_jax", "label", "nowhere.c3d", "--model", "model.json", "-o", "out"]
    done = subprocess.run(order, capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and "nowhere.c3d" in done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["label"],
        ["label", "walk.c3d"],
        ["label", "walk.c3d", "-o", "out", "--method", "guess"],
        ["label", "walk.c3d", "-o", "out", "--model", "nowhere.json"],
        ["label", "walk.c3d", "-o", "out", "--settings", "nowhere.toml"],
        ["label", ".", "-o", "."],
        ["label", ".", "-o", "out", "--shard", "2/2"],
        ["label", ".", "-o", "out", "--shard", "first"],
        ["label", ".", "-o", "out", "--workers", "0"],
        ["label", ".", "-o", "out", "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"],
        ["label", ".", "-o", "out", "--scheduler", "tcp://127.0.0.1:1", "--shard", "0/2"],
        ["label", ".", "-o", "out", "--completeness", "2"],
        ["label", ".", "-o", "out", "--confidence", "sure"],
        ["label", ".", "-o", "out", "--confidence", ".9", "--method", "paper"],
        ["label", ".", "-o", "out", "--log-file", "nowhere/run.log"],
        ["label", "walk.c3d", "-o", "model.json"],
        ["model", "walk.c3d"],
        ["model", "walk.c3d", "-o", "walk.c3d"],
        ["model", "walk.c3d", "-o", "m.json", "--segments", "s.toml", "--template", "t"],
        ["model", "nick.vsk", "walk.c3d", "-o", "m.json"],
        ["model", "nick.vsk", "-o", "m.json", "--template", "plug-in-gait"],
        ["check"],
        ["check", "walk.c3d"],
        ["check", "walk.c3d", "--model", "nowhere.json"],
        ["check", "walk.c3d", "--model", "model.json", "--json", "walk.c3d"],
        ["fly"],
    ],
)
def test_wrong_usage(folder, capsys, arguments):
    before = {p: p.read_bytes() for p in folder.iterdir()}
    status, _, err = command(capsys, *arguments)
    assert status == 2 and err
    assert {p: p.read_bytes() for p in folder.iterdir()} == before


def bad_inputs():
    nothing_seen = Recording(np.full((5, 3, 3), np.nan), tuple(MARKERS), 100.0)
    return {
        "missing": (None, "no such file"),
        "empty": (b"", "the file is empty"),
        "foreign": (b"%PDF-1.7" * 200, "no C3D file"),
        "truncated": (lambda p: io.write_c3d(make_recording(500), p), "truncated"),
        "no points": (lambda p: io.write_c3d(Recording(np.ones((5, 0, 3)), (), 100.0), p), "no points"),
        "nothing seen": (lambda p: io.write_c3d(nothing_seen, p), "not one point was seen"),
    }


@pytest.mark.parametrize("kind", bad_inputs())
@pytest.mark.parametrize("order", ["label", "model"])
def test_bad_recordings(folder, capsys, kind, order):
    content, wrong = bad_inputs()[kind]
    path = folder / "bad.c3d"
    if callable(content):
        content(path)
    elif content is not None:
        path.write_bytes(content)
    if kind == "truncated":
        path.write_bytes(path.read_bytes()[:4000])
    out = "out" if order == "label" else "new.json"
    status, _, err = command(capsys, order, "bad.c3d", "-o", out)
    assert status == 1 and err.count("\n") == 1 and "bad.c3d" in err and wrong in err
    assert not (folder / "new.json").exists() and not list(folder.glob("out/bad*"))


def test_a_rate_of_zero(folder, capsys):
    (folder / "bad.trc").write_text("PathFileType\nDataRate\tUnits\n0\tmm\nFrame#\tTime\tA\n\n1\t0\t1\t2\t3\n")
    for order in (["label", "bad.trc", "-o", "out"], ["model", "bad.trc", "-o", "new.json"]):
        status, _, err = command(capsys, *order)
        assert status == 1 and "bad.trc: its rate is 0" in err and err.count("\n") == 1


def test_one_frame(folder, capsys, labeller):
    io.write_c3d(make_recording(60).frames(3, 4), folder / "one.c3d")
    status, _, err = command(capsys, "label", "one.c3d", "-o", "out")
    assert status in (0, 1) and err.count("\n") <= 1
    status, _, err = command(capsys, "model", "one.c3d", "-o", "new.json")
    assert status in (0, 1) and err.count("\n") <= 1


def test_demo_is_handed_its_folder(folder, capsys, monkeypatch):
    asked = []
    monkeypatch.setitem(sys.modules, "dshpm_jax._demo.capture", SimpleNamespace(run=lambda out: asked.append(out) or 0))
    assert command(capsys, "demo", "-o", "here")[0] == 0 and command(capsys, "demo")[0] == 0
    assert [str(out) for out in asked] == ["here", "None"]
