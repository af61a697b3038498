"""What somebody has is never overwritten, and what cannot be written is said."""

import os
from io import BytesIO, TextIOWrapper
from pathlib import Path

import pytest
from making import make_model, make_recording
from running import MARKERS, contents, rows_of, run
from text_files import TRC, VICON

from dshpm_jax import io
from dshpm_jax._archive import FAILED, KEPT, Due, Order, find_jobs, in_shard, label_archive, what_is_due
from dshpm_jax._console import say
from dshpm_jax._messages import UsageError
from dshpm_jax._settings import Settings
from dshpm_jax.io import Form


@pytest.mark.parametrize("force", [False, True])
def test_a_result_that_somebody_edited_stays(archive, tmp_path, labeller, force):
    out = tmp_path / "out"
    run(archive, out)
    edited = out / "bob" / "run.c3d"
    io.write_c3d(make_recording(7), edited)
    before = edited.read_bytes()
    assert force or run(archive, out)["bob/run.c3d"].was_there  # nothing changed that it depends on
    io.write_c3d(make_recording(30, seed=9), archive / "bob" / "run.c3d")
    outcome = run(archive, out, force=force)["bob/run.c3d"]
    assert outcome.outcome == KEPT and "changed by somebody" in outcome.message
    assert edited.read_bytes() == before


def test_a_file_that_somebody_puts_there_meanwhile_stays(archive, tmp_path, labeller, monkeypatch):
    target, write = tmp_path / "out" / "bob" / "run.c3d", io.write_labelled

    def slowly(labelling, path, form):
        write(labelling, path, form)
        if path.name == "run.c3d":
            target.write_bytes(b"somebody's only copy")

    monkeypatch.setattr(io, "write_labelled", slowly)
    assert run(archive, tmp_path / "out")["bob/run.c3d"].outcome == KEPT
    assert target.read_bytes() == b"somebody's only copy" and len(list(target.parent.iterdir())) == 1


def test_a_recording_that_changes_meanwhile(archive, tmp_path, labeller, monkeypatch):
    write = io.write_labelled

    def slowly(labelling, path, form):
        write(labelling, path, form)
        with labelling.recording.source.open("ab") as file:
            file.write(b"more")

    monkeypatch.setattr(io, "write_labelled", slowly)
    outcome = run(archive / "bob", tmp_path / "out")["run.c3d"]
    assert outcome.outcome == FAILED and "run.c3d: changed while it was labelled" in outcome.message
    assert not (tmp_path / "out" / "run.c3d").exists() and not (tmp_path / "out" / "run.labels.json").exists()


def test_files_that_are_not_ours_stay(archive, tmp_path, labeller):
    out = tmp_path / "out"
    (out / "bob").mkdir(parents=True)
    (out / "bob" / "run.c3d").write_bytes(b"somebody's only copy")
    outcome = run(archive, out, force=True)["bob/run.c3d"]
    assert outcome.outcome == KEPT and "not overwritten" in outcome.message
    assert (out / "bob" / "run.c3d").read_bytes() == b"somebody's only copy"


def test_originals_are_never_overwritten(archive, tmp_path):
    with pytest.raises(UsageError, match="is an input"):
        find_jobs([archive], (), archive)
    with pytest.raises(UsageError, match="would overwrite an input"):
        find_jobs([archive / "bob" / "run.c3d"], (), archive / "bob")
    with pytest.raises(UsageError, match="is a file"):
        find_jobs([archive], (), archive / "bob" / "run.c3d")


def test_a_result_that_cannot_be_written(archive, tmp_path, labeller, monkeypatch):
    def refuse(labelling, path, form):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(io, "write_labelled", refuse)
    outcomes = run(archive, tmp_path / "out")
    assert "No space left" in outcomes["bob/run.c3d"].message
    assert sorted(contents(tmp_path / "out")) == ["manifest.jsonl", "report.html", "summary.csv"]


def test_a_full_disk_leaves_what_was_there(archive, tmp_path, labeller, monkeypatch):
    out = tmp_path / "out"
    run(archive, out)
    before = contents(out)

    def refuse(self, chunks):
        raise OSError(28, "No space left on device", str(self))

    monkeypatch.setattr("dshpm_jax.io._c3d_format.write_whole", refuse)
    outcomes = run(archive, out, force=True)
    assert all("No space left" in o.message for name, o in outcomes.items() if name != "eve/jump.c3d")
    unlike = {"manifest.jsonl", "report.html", "summary.csv"}
    assert contents(out).keys() == before.keys()
    assert all(before[name] == content for name, content in contents(out).items() if name not in unlike)


def test_rows_that_cannot_be_appended_are_written_at_the_end(archive, tmp_path, labeller, monkeypatch):
    out = tmp_path / "out"
    outcomes = label_archive(find_jobs([archive], (), out), Order(out))
    first = next(outcomes)
    opened = Path.open

    def full(self, mode="r", *more, **named):
        if self.name == "manifest.jsonl" and mode == "a":
            raise OSError(28, "No space left on device")
        return opened(self, mode, *more, **named)

    monkeypatch.setattr(Path, "open", full)
    assert len([first, *outcomes]) == len(rows_of(out)) == 4


def test_a_manifest_that_cannot_be_written_is_said_at_the_end(archive, tmp_path, labeller, monkeypatch):
    def full(path, chunks):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("dshpm_jax._archive.manifest.write_whole", full)
    with pytest.raises(io.WriteError, match="no manifest can be written .No space left on device"):
        run(archive, tmp_path / "out")
    assert (tmp_path / "out" / "bob" / "run.c3d").exists()


def test_a_page_that_cannot_be_made_is_said_at_the_end(archive, tmp_path, labeller, monkeypatch):
    def broken(out, rows):
        raise KeyError("rate")

    monkeypatch.setattr("dshpm_jax._archive.run.write_run_page", broken)
    with pytest.raises(io.WriteError, match="no page can be made .KeyError: 'rate'"):
        run(archive, tmp_path / "out")
    assert len(rows_of(tmp_path / "out")) == 4


@pytest.mark.parametrize("name", ["summary.csv", "manifest.jsonl"])
def test_files_of_the_names_of_ours_stay(archive, tmp_path, labeller, name):
    out = tmp_path / "out"
    out.mkdir()
    (out / name).write_text("subject,age\nann,31\n")
    with pytest.raises(UsageError, match="is there and none of our files, not overwritten"):
        run(archive, out)
    assert contents(out) == {name: b"subject,age\nann,31\n"}


def test_a_recording_called_like_the_summary_stays(tmp_path, labeller):
    captures = tmp_path / "captures"
    captures.mkdir()
    io.write_model(make_model(MARKERS), captures / "model.json")
    (captures / "summary.csv").write_text(VICON)
    with pytest.raises(UsageError, match="summary.csv: would overwrite an input"):
        find_jobs([captures / "summary.csv"], (), captures)
    (job,) = find_jobs([captures], (), tmp_path / "out", kind="same")
    assert "its result would overwrite summary.csv of the run" in job.problem
    (outcome,) = label_archive([job], Order(tmp_path / "out"))
    assert outcome.outcome == FAILED and len(rows_of(tmp_path / "out")) == 1


def test_the_result_of_another_recording_stays(archive, tmp_path, labeller):
    """Two folders labelled into one, one after the other, with a recording of the same name."""
    out, other = tmp_path / "out", tmp_path / "other"
    run(archive / "bob", out)
    before = contents(out)
    other.mkdir()
    io.write_model(make_model(MARKERS), other / "model.json")
    io.write_c3d(make_recording(33, seed=9), other / "run.c3d")
    outcome = run(other, out)["run.c3d"]
    assert outcome.outcome == KEPT and f"is the result of {archive / 'bob' / 'run.c3d'}" in outcome.message
    assert {k: v for k, v in contents(out).items() if k.startswith("run.")} == {
        k: v for k, v in before.items() if k.startswith("run.")
    }
    assert len(rows_of(out)) == 2
    (archive / "bob" / "run.c3d").rename(tmp_path / "moved.c3d")  # whose result it was is gone
    assert run(other, out)["run.c3d"].ok


def test_a_result_gives_way_to_one_in_another_format(tmp_path, labeller):
    """It would be no result without its sidecar, so it goes; but not where somebody changed it, or it is another's."""
    folder, out = tmp_path / "captures", tmp_path / "out"
    folder.mkdir()
    io.write_model(make_model(MARKERS), folder / "model.json")
    (folder / "walk.trc").write_text(TRC)
    loose = Settings(completeness=0.1)
    assert run(folder, out, loose)["walk.c3d"].ok
    jobs = find_jobs([folder], (), out, kind="same")
    (due,) = what_is_due(jobs, Order(out, loose), {})
    assert isinstance(due, Due) and due.why == "has a result in another format, walk.c3d, which gives way"
    for _ in range(2):
        assert [o.job.target.name for o in label_archive(jobs, Order(out, loose))] == ["walk.trc"]
        assert not (out / "walk.c3d").exists() and rows_of(out).keys() == {"walk.trc"}
    assert len(labeller) == 2  # the second run found nothing to do
    other = tmp_path / "other"
    other.mkdir()
    io.write_model(make_model(MARKERS), other / "model.json")
    io.write_c3d(make_recording(33, seed=9), other / "walk.c3d")
    before = contents(out)
    outcome = run(other, out)["walk.c3d"]
    assert outcome.outcome == KEPT and f"is the result of {folder / 'walk.trc'}" in outcome.message
    (other / "walk.c3d").unlink()
    (folder / "walk.trc").rename(tmp_path / "moved.trc")
    (job,) = find_jobs([out / "walk.trc"], (folder / "model.json",), out)
    (outcome,) = label_archive([job], Order(out, loose))  # a result labelled once more must not go
    assert outcome.outcome == KEPT and "its result would take its place" in outcome.message
    (tmp_path / "moved.trc").rename(folder / "walk.trc")
    (out / "walk.trc").write_text(TRC)
    outcome = run(folder, out, loose)["walk.c3d"]
    assert outcome.outcome == KEPT and "walk.trc: was changed by somebody" in outcome.message
    assert (out / "walk.trc").read_text() == TRC and contents(out).keys() == before.keys()


def test_another_form_is_made_anew_and_the_same_one_is_up_to_date(archive, tmp_path, labeller):
    out = tmp_path / "out"
    run(archive / "bob", out)
    plain = contents(out)
    for form in (Form(up="y", unit="m"), Form(up="y"), Form(keep_unknown=True), Form()):
        jobs = find_jobs([archive / "bob"], (), out, form=form)
        (due,) = what_is_due(jobs, Order(out), {})
        assert isinstance(due, Due) and due.why == "the form of results changed since it was labelled"
        for there in (False, True):
            (outcome,) = label_archive(jobs, Order(out))
            assert outcome.ok and outcome.was_there is there
        written = io.read_sidecar_head(out / "run.labels.json").get("written", {})
        assert written == {**({"axes": "x,z,-y"} if form.up else {}), **({"unit": "m"} if form.unit else {})}
    assert {k: v for k, v in contents(out).items() if k.startswith("run.")} == {
        k: v for k, v in plain.items() if k.startswith("run.")
    }


def test_axes_of_text_that_cannot_be_turned_are_a_problem(tmp_path):
    (tmp_path / "vicon.csv").write_text(VICON)
    io.write_model(make_model(MARKERS), tmp_path / "model.json")
    (job,) = find_jobs([tmp_path / "vicon.csv"], (), tmp_path / "out", "same", Form(unit="m"))
    assert job.problem == "axes and units are changed in C3D and TRC alone; give --format trc"
    (job,) = find_jobs([tmp_path / "vicon.csv"], (), tmp_path / "out", "trc", Form(unit="m"))
    assert not job.problem and job.target.name == "vicon.trc"


def test_names_that_are_no_text_harm_nothing(archive, tmp_path, labeller, capsys):
    strange = archive / "bob" / os.fsdecode(b"M\xfcller.c3d")
    try:
        io.write_c3d(make_recording(21), strange)
    except OSError:
        pytest.skip("this file system has no such names")
    outcomes = run(archive, tmp_path / "out")
    assert all(o.ok for name, o in outcomes.items() if name != "eve/jump.c3d")
    assert "M\\udcfcller.c3d" in (tmp_path / "out" / "summary.csv").read_text()
    jobs = find_jobs([archive], (), tmp_path / "out")
    assert sum(len(in_shard(jobs, (k, 3))) for k in range(3)) == 5
    shown = TextIOWrapper(BytesIO(), encoding="ascii")
    say(f"{strange}: labelled", shown)
    shown.seek(0)
    assert shown.read().endswith("M\\udcfcller.c3d: labelled\n")
