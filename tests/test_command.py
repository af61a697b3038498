"""The command line: exit statuses, one line for each trouble, and never a traceback."""

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from making import make_labelling, make_recording
from text_files import FILES

from dshpm_jax import Recording, io
from dshpm_jax.__main__ import main

MARKERS = ["LASI", "RASI", "SACR"]


@pytest.fixture
def labeller(monkeypatch):
    """Stands in for the real one: a column gets the label that it carries."""

    def label_many(recordings, models, settings):
        for recording, model in zip(recordings, models, strict=True):
            yield make_labelling(recording, list(model.markers))

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))


def command(capsys, *arguments):
    """Exit status, standard output, and standard error, which is at most a line for each trouble."""
    try:
        status = main([str(a) for a in arguments])
    except SystemExit as stop:  # argparse
        status = stop.code
    out, err = capsys.readouterr()
    assert "Traceback" not in err
    return status, out, err


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


def test_label(folder, capsys, labeller):
    status, out, err = command(capsys, "label", "walk.c3d", "-o", "out")
    assert (status, err) == (0, "")
    assert "walk.c3d: labelled, " in out and "1 of 1 recordings labelled" in out
    assert (folder / "out" / "walk.c3d").exists() and (folder / "out" / "walk.labels.json").exists()
    status, out, err = command(capsys, "label", "walk.c3d", "-o", "out")
    assert status == 0 and "walk.c3d: up to date" in out
    status, out, err = command(capsys, "label", "walk.c3d", "-o", "out", "--method", "paper")
    assert status == 0 and "walk.c3d: labelled, " in out
    status, out, err = command(capsys, "label", "walk.c3d", "-o", "out", "--method", "paper", "--force")
    assert status == 0 and "walk.c3d: labelled, " in out


def test_dry_run_says_what_is_due_and_why_without_jax(folder, capsys, labeller):
    code = (
        "import sys\nfrom dshpm_jax.__main__ import main\n"
        "assert main(['label', 'walk.c3d', '-o', 'out', '--dry-run']) == 0\nsys.exit('jax' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and not (folder / "out").exists()
    assert done.stdout.splitlines() == [
        "walk.c3d: would be labelled with model.json into out/walk.c3d; it has no result yet",
        "1 of 1 recordings would be labelled",
    ]
    command(capsys, "label", "walk.c3d", "-o", "out")
    assert "walk.c3d: up to date" in command(capsys, "label", "walk.c3d", "-o", "out", "--dry-run")[1]
    io.write_c3d(make_recording(50), folder / "walk.c3d")
    status, out, err = command(capsys, "label", "walk.c3d", "-o", "out", "--dry-run", "--method", "paper")
    assert (status, err) == (0, "") and "its input and the settings changed since it was labelled" in out
    (folder / "model.json").unlink()
    status, out, err = command(capsys, "label", "walk.c3d", "-o", "out", "--dry-run")
    assert status == 1 and "no model.json" in err and "0 of 1" in out


def test_thresholds(folder, capsys, labeller):
    status, _, err = command(capsys, "label", "walk.c3d", "-o", "out", "--completeness", "1")
    assert status == 1 and "of its markers found" in err
    (folder / "s.toml").write_text("min_confidence = 0.5\ncompleteness = 1.0\n")
    thresholds = ["--settings", "s.toml", "--confidence", ".9", "--completeness", ".5"]
    assert command(capsys, "label", "walk.c3d", "-o", "out", *thresholds)[0] == 0
    written = io.read_sidecar_head(folder / "out" / "walk.labels.json")["settings"]
    assert (written["min_confidence"], written["completeness"]) == (0.9, 0.5)


def test_log_file(folder, capsys, labeller):
    (folder / "bad.c3d").write_bytes(b"")
    for _ in range(2):
        assert command(capsys, "label", "bad.c3d", "walk.c3d", "-o", "out", "--log-file", "run.log")[0] == 1
    log = (folder / "run.log").read_text()
    assert log.count("bad.c3d: the file is empty") >= 2 and "Traceback" in log and "walk.c3d: labelled, " in log
    before = (folder / "walk.c3d").read_bytes()
    assert command(capsys, "label", "walk.c3d", "-o", "out", "--log-file", "walk.c3d")[0] == 2
    assert (folder / "walk.c3d").read_bytes() == before


def test_shards(folder, capsys, labeller):
    for k in range(5):
        io.write_c3d(make_recording(20, seed=k), folder / f"{k}.c3d")
    counts = []
    for share in ("0/2", "1/2"):
        status, out, err = command(capsys, "label", ".", "-o", "out", "--shard", share)
        assert (status, err) == (0, "")
        counts.append(int(out.splitlines()[-1].split()[0]))
    assert sum(counts) == 6 == len(list((folder / "out").glob("*.c3d"))) and min(counts) > 0


def test_results_in_the_format_of_their_recordings(folder, capsys, labeller):
    for name, content in FILES.items():
        (folder / "captures" / name).parent.mkdir(exist_ok=True)
        (folder / "captures" / name).write_text(content)
    (folder / "captures" / "walk.c3d").write_bytes((folder / "walk.c3d").read_bytes())
    (folder / "captures" / "summary.csv").write_text("no,recording\n1,2\n")
    order = ("label", "captures", "--model", "model.json", "-o", "out", "--completeness", "0.1")
    status, out, err = command(capsys, *order, "--format", "same")
    assert (status, err) == (0, "") and f"{len(FILES) + 1} of {len(FILES) + 1} recordings labelled" in out
    for name in [*FILES, "walk.c3d"]:
        assert io.read(folder / "out" / name).labels[:3] == tuple(MARKERS)
    status, out, err = command(capsys, *order[:4], "-o", "all-c3d", "--completeness", "0.1")
    assert (
        status == 0 and (folder / "all-c3d" / "vicon.c3d").exists() and not (folder / "all-c3d" / "vicon.csv").exists()
    )


def test_names_that_count_as_none(folder, capsys, labeller):
    io.write_c3d(make_recording(labels=("LASI", "ghost", "ghost", "SACR")), folder / "ghosts.c3d")
    status, _, err = command(capsys, "label", "ghosts.c3d", "-o", "out")
    assert status == 1 and "two points have the label 'ghost'" in err
    assert command(capsys, "label", "ghosts.c3d", "-o", "out", "--unlabelled", "gh*")[0] == 0
    (folder / "s.toml").write_text('unlabelled = ["nobody", "ghost"]')
    assert command(capsys, "label", "ghosts.c3d", "-o", "out", "--settings", "s.toml")[0] == 0
    assert io.read_sidecar_head(folder / "out" / "ghosts.labels.json")["settings"]["unlabelled"] == ["nobody", "ghost"]
    for wrong in ('"ghost"', '[""]', "[1]"):
        (folder / "s.toml").write_text(f"unlabelled = {wrong}")
        status, _, err = command(capsys, "label", "ghosts.c3d", "-o", "out", "--settings", "s.toml")
        assert status == 2 and 'unlabelled is a list of names such as ["ghost*"]' in err
    assert command(capsys, "model", "ghosts.c3d", "-o", "new.json", "--unlabelled", "ghost")[0] == 0
    assert io.read_model(folder / "new.json").markers == ("LASI", "SACR")


def test_settings_file(folder, capsys, labeller):
    (folder / "s.toml").write_text('method = "static"\n')
    assert command(capsys, "label", "walk.c3d", "-o", "out", "--settings", "s.toml")[0] == 0
    assert '"method": "static"' in (folder / "out" / "walk.labels.json").read_text()
    (folder / "s.toml").write_text("methd = 1\n")
    status, _, err = command(capsys, "label", "walk.c3d", "-o", "out", "--settings", "s.toml")
    assert status == 2 and "methd" in err and err.count("\n") == 1
    for wrong in ("num_key_frames = 2.5", "window_steps = true", "min_confidence = nan", "completeness = []"):
        (folder / "s.toml").write_text(wrong + "\n")
        status, _, err = command(capsys, "label", "walk.c3d", "-o", "out", "--settings", "s.toml")
        assert status == 2 and wrong.split()[0] in err and err.count("\n") == 1
    (folder / "s.toml").write_text("a" * 5000 + " = 1\n")
    assert len(command(capsys, "label", "walk.c3d", "-o", "out", "--settings", "s.toml")[2]) < 700
    (folder / "s.toml").write_text("methd = " + "[" * 100_000)
    status, _, err = command(capsys, "label", "walk.c3d", "-o", "out", "--settings", "s.toml")
    assert status == 2 and "no settings can be read" in err and err.count("\n") == 1


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
        "duplicates": (lambda p: io.write_c3d(make_recording(9, ["A", "A"]), p), "two points have the label 'A'"),
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


def test_a_folder_without_recordings(folder, capsys):
    (folder / "bare").mkdir()
    status, _, err = command(capsys, "label", "bare", "-o", "out")
    assert status == 1 and "no recordings in this folder" in err


def test_one_bad_file_of_two(folder, capsys, labeller):
    (folder / "bad.c3d").write_bytes(b"")
    status, out, err = command(capsys, "label", "bad.c3d", "walk.c3d", "-o", "out")
    assert status == 1 and err.count("\n") == 1 and "1 of 2 recordings labelled" in out


def test_model(folder, capsys):
    status, out, err = command(capsys, "model", "walk.c3d", "-o", "new/model.json")
    assert (status, err) == (0, "") and "3 markers" in out
    assert io.read_model(folder / "new" / "model.json").markers
    assert command(capsys, "model", "walk.c3d", "-o", "new/model.json")[0] == 0  # a model gives way to a model


SUBJECT = """<KinematicModel><Skeleton><Segment NAME="Hip"><JointFree /></Segment></Skeleton><MarkerSet><Markers>
<Marker NAME="LASI" SEGMENT="Hip" POSITION="0 0 0" /><Marker NAME="RASI" SEGMENT="Hip" POSITION="240 0 0" />
<Marker NAME="SACR" SEGMENT="Hip" POSITION="120 0 -200" /></Markers></MarkerSet></KinematicModel>"""


def test_a_subject_file_is_a_model(folder, capsys, labeller):
    (folder / "nick.vsk").write_text(SUBJECT)
    status, out, err = command(capsys, "model", "nick.vsk", "-o", "nick.json")
    assert (status, out, err) == (0, "nick.json: 3 markers in 1 segments\n", "")
    assert io.read_model(folder / "nick.json").markers == tuple(MARKERS)
    status, out, err = command(capsys, "label", "walk.c3d", "--model", "nick.vsk", "-o", "out")
    assert (status, err) == (0, "") and io.read(folder / "out" / "walk.c3d").labels[:3] == tuple(MARKERS)


def test_a_damaged_subject_file(folder, capsys):
    (folder / "nick.vsk").write_text(SUBJECT[:100])
    status, _, err = command(capsys, "model", "nick.vsk", "-o", "nick.json")
    assert status == 1 and err.count("\n") == 1 and "nick.vsk: is no XML" in err


def test_model_of_unlabelled_points(folder, capsys):
    io.write_c3d(make_recording(9, ["*1", "*2", "*3"]), folder / "raw.c3d")
    status, _, err = command(capsys, "model", "raw.c3d", "-o", "new.json")
    assert status == 1 and "raw.c3d: none of its points has a label" in err and err.count("\n") == 1


def test_model_with_a_wrong_segments_file(folder, capsys):
    (folder / "s.toml").write_text('[hip]\nmarkers = ["LASI", "NOSE"]\n')
    status, _, err = command(capsys, "model", "walk.c3d", "-o", "new.json", "--segments", "s.toml")
    assert status == 1 and "s.toml: the segment 'hip' names NOSE" in err and err.count("\n") == 1
    assert not (folder / "new.json").exists()


def test_model_with_an_unknown_template(folder, capsys):
    status, _, err = command(capsys, "model", "walk.c3d", "-o", "new.json", "--template", "octopus")
    assert status == 1 and "octopus" in err and err.count("\n") == 1


def test_one_frame(folder, capsys, labeller):
    io.write_c3d(make_recording(60).frames(3, 4), folder / "one.c3d")
    status, _, err = command(capsys, "label", "one.c3d", "-o", "out")
    assert status in (0, 1) and err.count("\n") <= 1
    status, _, err = command(capsys, "model", "one.c3d", "-o", "new.json")
    assert status in (0, 1) and err.count("\n") <= 1


def test_interrupted(folder, capsys, monkeypatch):
    def label_many(*_):
        raise KeyboardInterrupt

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
    status, _, err = command(capsys, "label", "walk.c3d", "-o", "out")
    assert status == 130 and err.count("\n") == 1
    assert not (folder / "out" / "walk.c3d").exists()


def test_demo_is_handed_its_folder(folder, capsys, monkeypatch):
    asked = []
    monkeypatch.setitem(sys.modules, "dshpm_jax._demo", SimpleNamespace(run=lambda out: asked.append(out) or 0))
    assert command(capsys, "demo", "-o", "here")[0] == 0 and command(capsys, "demo")[0] == 0
    assert [str(out) for out in asked] == ["here", "None"]


@pytest.fixture
def checker(monkeypatch):
    """Stands in for the real one: finds that the first column is the second marker in the first two frames."""

    def check(recording, model, driver):
        if recording.num_frames == 9:
            return []
        return [SimpleNamespace(label="LASI", column=0, first=0, last=1, should_be="RASI", confidence=0.98765)]

    monkeypatch.setitem(sys.modules, "dshpm_jax._check", SimpleNamespace(check=check, Finding=None))
    monkeypatch.delitem(sys.modules, "dshpm_jax._checking", raising=False)
    yield
    sys.modules.pop("dshpm_jax._checking", None)  # it holds the stand-in


def test_check(folder, capsys, checker):
    io.write_c3d(make_recording(9, MARKERS), folder / "sound.c3d")
    status, out, err = command(capsys, "check", "sound.c3d", "--model", "model.json")
    assert (status, out, err) == (0, "sound.c3d: no wrong label found\n", "")
    status, out, err = command(capsys, "check", "walk.c3d", "sound.c3d", "--model", "model.json", "--json", "f.json")
    assert status == 1 and err == ""
    assert out.splitlines()[0] == "walk.c3d: LASI, frames 1-2, should be RASI (confidence 0.988)"
    (row,) = json.loads((folder / "f.json").read_text())
    assert (row["frames"], row["file_frames"], row["should_be"]) == ([0, 1], [1, 2], "RASI")


def test_check_of_files_that_cannot_be(folder, capsys, checker):
    (folder / "bad.c3d").write_bytes(b"")
    status, out, err = command(capsys, "check", "bad.c3d", "walk.c3d", "--model", "model.json")
    assert status == 1 and "bad.c3d: the file is empty" in err and err.count("\n") == 1 and "walk.c3d: LASI" in out
    (folder / "other.json").write_text("{}")
    status, out, err = command(capsys, "check", "walk.c3d", "--model", "other.json")
    assert status == 1 and "this is no marker model" in err and err.count("\n") == 1


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
