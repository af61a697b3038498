"""`label`: what it says, the settings and thresholds that it takes, and its exit status."""

import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

from browser import data_of
from commands import command
from making import make_labelling, make_recording
from text_files import FILES

from dshpm_jax import io

MARKERS = ["LASI", "RASI", "SACR"]


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


def test_the_first_line_comes_before_jax_and_before_folders_are_searched(folder, capsys, monkeypatch):
    code = (
        "import sys\nfrom dshpm_jax.__main__ import main\nimport dshpm_jax._commands.label as label\n"
        "label.find_jobs = lambda *_: sys.exit('jax' in sys.modules)\n"
        "main(['label', 'walk.c3d', 'a', 'b', 'c', '-o', 'out'])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout == "looking for recordings in walk.c3d, a, b and 1 more\n"


def test_the_page_is_named_at_the_end(folder, capsys, labeller):
    _, out, _ = command(capsys, "label", "walk.c3d", "-o", "out")
    page = folder / "out" / "report.html"
    assert out.splitlines()[-1] == f"open {page.relative_to(folder)} in a browser to see what needs you"
    page.write_text("mine")  # no page of ours, so none is written
    status, out, err = command(capsys, "label", "walk.c3d", "-o", "out", "--force")
    assert status == 1 and "report.html" in err and "in a browser" not in out


def test_each_trial_gets_a_page_that_the_report_leads_to(folder, capsys, labeller):
    assert command(capsys, "label", "walk.c3d", "-o", "out")[0] == 0
    assert {path.name for path in (folder / "out").glob("*.html")} == {"walk.html", "report.html"}
    assert data_of((folder / "out" / "report.html").read_text())["trials"][0][-1] == {"page": 1}
    made = (folder / "out" / "walk.html").read_text()
    assert command(capsys, "view", "out")[0] == 0
    assert data_of((folder / "out" / "walk.html").read_text()) == data_of(made)
    assert command(capsys, "label", "walk.c3d", "-o", "without", "--no-pages")[0] == 0
    assert [path.name for path in (folder / "without").glob("*.html")] == ["report.html"]
    assert "up to date" in command(capsys, "label", "walk.c3d", "-o", "without")[1]
    assert data_of((folder / "without" / "walk.html").read_text()) == data_of(made)
    assert data_of((folder / "without" / "report.html").read_text())["trials"][0][-1] == {"page": 1}


def test_a_file_in_the_place_of_a_page_stays(folder, capsys, labeller):
    (folder / "out").mkdir()
    (folder / "out" / "walk.html").write_text("my own")
    assert command(capsys, "label", "walk.c3d", "-o", "out")[0] == 0
    assert (folder / "out" / "walk.html").read_text() == "my own"
    assert data_of((folder / "out" / "report.html").read_text())["trials"][0][-1] == {}


def test_doubtful_labels_are_status_1(folder, capsys, monkeypatch):
    def label_many(recordings, models, settings, known):
        for recording, model in zip(recordings, models, strict=True):
            yield replace(make_labelling(recording, list(model.markers)), stats={"model_fit": 0.5})

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
    status, out, err = command(capsys, "label", "walk.c3d", "-o", "out")
    assert status == 1 and "walk.c3d: doubtful, " in out and "0 of 1 recordings labelled, 1 doubtful" in out
    assert err.startswith("dshpm-jax: walk.c3d: doubtful, its labels hold only 50% of the usual evidence; check it")


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
    assert status == 1 and "of the points of its markers" in err
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
        counts.append(int(out.splitlines()[-2].split()[0]))
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
    assert command(capsys, "label", "ghosts.c3d", "-o", "out")[0] == 0
    status, _, err = command(capsys, "model", "ghosts.c3d", "-o", "new.json")
    assert (
        status == 1 and "columns 2 and 3 are both named 'ghost', in" in err and "leave one out with --drop '#3'" in err
    )
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


def test_a_folder_without_recordings(folder, capsys):
    (folder / "bare").mkdir()
    status, _, err = command(capsys, "label", "bare", "-o", "out")
    assert status == 1 and "no recordings in this folder" in err


def test_one_bad_file_of_two(folder, capsys, labeller):
    (folder / "bad.c3d").write_bytes(b"")
    status, out, err = command(capsys, "label", "bad.c3d", "walk.c3d", "-o", "out")
    assert status == 1 and err.count("\n") == 1 and "1 of 2 recordings labelled" in out


def test_interrupted(folder, capsys, monkeypatch):
    def label_many(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
    status, _, err = command(capsys, "label", "walk.c3d", "-o", "out")
    assert status == 130 and err.count("\n") == 1
    assert not (folder / "out" / "walk.c3d").exists()


def test_results_for_opensim(folder, capsys, labeller):
    """TRC with Y up in metres; the file of that format takes the place of the one that was there."""
    assert command(capsys, "label", "walk.c3d", "-o", "out")[0] == 0
    order = ["label", "walk.c3d", "-o", "out", "--format", "trc", "--up", "y", "--unit", "m"]
    status, out, err = command(capsys, *order, "--dry-run")
    assert "it has a result in another format, walk.c3d, which gives way" in out
    assert command(capsys, *order)[0] == 0
    assert not (folder / "out" / "walk.c3d").exists()
    before, after = io.read(folder / "walk.c3d"), io.read(folder / "out" / "walk.trc")
    x, y, z = before["LASI"].T
    assert after.unit == "m" and abs(after["LASI"].T - [x, z, -y]).max() < 1e-3
    written = io.read_sidecar_head(folder / "out" / "walk.labels.json")["written"]
    assert written == {"axes": "x,z,-y", "unit": "m"}
    assert "walk.c3d: up to date" in command(capsys, *order)[1]


def test_wrong_axes_are_wrong_usage(folder, capsys):
    for wrong, why in {"x,y,-z": "would mirror", "x,y": "in some order"}.items():
        status, _, err = command(capsys, "label", "walk.c3d", "-o", "out", "--axes", wrong)
        assert status == 2 and why in err and err.count("\n") == 1
