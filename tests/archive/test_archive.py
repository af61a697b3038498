"""Runs over folders: what is found, what is written, and that one file's trouble stays its own."""

import csv
import hashlib
import itertools
import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from making import make_labelling, make_model, make_recording

from dshpm_jax import io
from dshpm_jax._archive import (
    FAILED,
    KEPT,
    LABELLED,
    PARTLY,
    Order,
    UsageError,
    find_jobs,
    in_shard,
    label_archive,
)
from dshpm_jax._settings import Settings

MARKERS = ["LASI", "RASI", "SACR"]


@pytest.fixture
def labeller(monkeypatch):
    """Stands in for the real one: a column gets the label that it carries; a rate of 13 Hz is more than it can do."""
    batches = []

    def label_many(recordings, models, settings):
        batches.append(len(recordings))
        for recording, model in zip(recordings, models, strict=True):
            if recording.rate == 13:
                raise RuntimeError("thirteen\nframes a second")
            yield make_labelling(recording, list(model.markers))

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
    return batches


@pytest.fixture
def archive(tmp_path) -> Path:
    """Two subjects with a model each, and a folder without one."""
    folder = tmp_path / "archive"
    for k, place in enumerate(["ann/walk.c3d", "ann/day 2/walk.C3D", "bob/run.c3d", "eve/jump.c3d"]):
        path = folder / place
        path.parent.mkdir(parents=True, exist_ok=True)
        io.write_c3d(make_recording(20 + k, seed=k), path)
    for name in ("ann", "bob"):
        io.write_model(make_model(MARKERS), folder / name / "model.json")
    (folder / "ann" / "notes.txt").write_text("no recording")
    return folder


def run(archive, out, settings=None, **order):
    outcomes = list(label_archive(find_jobs([archive], (), out), Order(out, settings or Settings(), **order)))
    return {o.job.target.as_posix(): o for o in outcomes}


def contents(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_jobs_and_their_models(archive, tmp_path):
    jobs = find_jobs([archive], (), tmp_path / "out")
    assert [(j.target.as_posix(), [m.parent.name for m in j.models]) for j in jobs] == [
        ("ann/walk.c3d", ["ann"]),
        ("ann/day 2/walk.c3d", ["ann"]),
        ("bob/run.c3d", ["bob"]),
        ("eve/jump.c3d", []),
    ]
    assert "no model.json" in jobs[3].problem
    # An input's own folder is the highest that is asked for a model.
    assert find_jobs([archive / "ann" / "day 2"], (), tmp_path / "out")[0].models == ()
    given = archive / "bob" / "model.json"
    assert {j.models for j in find_jobs([archive], [given], tmp_path / "out")} == {(given,)}


def test_a_folder_mirrored(archive, tmp_path, labeller):
    before, out = contents(archive), tmp_path / "out"
    outcomes = run(archive, out)
    assert {name: o.outcome for name, o in outcomes.items()} == {
        "ann/walk.c3d": LABELLED,
        "ann/day 2/walk.c3d": LABELLED,
        "bob/run.c3d": LABELLED,
        "eve/jump.c3d": FAILED,
    }
    assert contents(archive) == before
    assert sorted(contents(out)) == [
        "ann/day 2/walk.c3d",
        "ann/day 2/walk.labels.json",
        "ann/walk.c3d",
        "ann/walk.labels.json",
        "bob/run.c3d",
        "bob/run.labels.json",
        "manifest.jsonl",
        "report.html",
        "summary.csv",
    ]
    assert io.read(out / "bob" / "run.c3d").labels[:3] == tuple(MARKERS)
    rows = {r["output"]: r for r in map(json.loads, (out / "manifest.jsonl").read_text().splitlines())}
    row = rows["bob/run.c3d"]
    assert row["sha256"] == hashlib.sha256((archive / "bob" / "run.c3d").read_bytes()).hexdigest()
    assert row["outcome"] == LABELLED and row["frames"] == 22 and 0.5 < row["completeness"] <= 1
    assert rows["eve/jump.c3d"]["outcome"] == FAILED and "give --model" in rows["eve/jump.c3d"]["message"]


def test_one_bad_file_harms_no_other(archive, tmp_path, labeller):
    io.write_c3d(make_recording(rate=13.0), archive / "ann" / "odd.c3d")
    (archive / "ann" / "empty.c3d").write_bytes(b"")
    (archive / "ann" / "broken.trc").write_text("nothing")
    outcomes = run(archive, tmp_path / "out")
    failed = {name: o.message for name, o in outcomes.items() if o.outcome == FAILED}
    assert sorted(failed) == ["ann/broken.c3d", "ann/empty.c3d", "ann/odd.c3d", "eve/jump.c3d"]
    assert failed["ann/odd.c3d"].endswith("odd.c3d: RuntimeError: thirteen frames a second")
    assert all("\n" not in text and str(archive) in text for text in failed.values())
    assert {name for name, o in outcomes.items() if o.ok} == {"ann/walk.c3d", "ann/day 2/walk.c3d", "bob/run.c3d"}
    assert labeller[0] == 4 and set(labeller[1:]) == {1}
    assert not (tmp_path / "out" / "ann" / "odd.c3d").exists()


def test_a_broken_model_harms_its_own_recordings_only(archive, tmp_path, labeller):
    (archive / "bob" / "model.json").write_text("{}")
    outcomes = run(archive, tmp_path / "out")
    assert outcomes["bob/run.c3d"].outcome == FAILED and "no marker model" in outcomes["bob/run.c3d"].message
    assert outcomes["ann/walk.c3d"].ok


def test_a_second_run_does_what_is_missing_or_changed(archive, tmp_path, labeller):
    out = tmp_path / "out"
    run(archive, out)
    first = contents(out)
    again = run(archive, out)
    assert {o.outcome for o in again.values() if o.was_there} == {LABELLED}
    assert [name for name, o in again.items() if not o.was_there] == ["eve/jump.c3d"]
    unlike = {"manifest.jsonl", "report.html", "summary.csv"}  # the failed file was tried again later
    assert {k: v for k, v in contents(out).items() if k not in unlike} == {
        k: v for k, v in first.items() if k not in unlike
    }

    io.write_c3d(make_recording(30, seed=9), archive / "bob" / "run.c3d")
    (out / "ann" / "walk.c3d").unlink()
    changed = run(archive, out)
    assert {name for name, o in changed.items() if o.ok and not o.was_there} == {"ann/walk.c3d", "bob/run.c3d"}
    assert contents(out)["ann/walk.c3d"] == first["ann/walk.c3d"]
    assert io.read(out / "bob" / "run.c3d").num_frames == 30


def made_again(archive, out, **order) -> set[str]:
    return {name for name, o in run(archive, out, **order).items() if o.ok and not o.was_there}


def test_what_makes_a_result_out_of_date(archive, tmp_path, labeller):
    out, every = tmp_path / "out", {"ann/walk.c3d", "ann/day 2/walk.c3d", "bob/run.c3d"}
    assert made_again(archive, out) == every
    assert made_again(archive, out, force=True) == every
    assert made_again(archive, out, settings=Settings(method="paper")) == every
    assert made_again(archive, out, settings=Settings(method="paper")) == set()
    io.write_model(make_model([*MARKERS[::-1]]), archive / "bob" / "model.json")
    assert made_again(archive, out, settings=Settings(method="paper")) == {"bob/run.c3d"}
    assert len(rows_of(out)) == 4


def test_a_stricter_threshold_judges_anew_and_labels_nothing(archive, tmp_path, labeller):
    out = tmp_path / "out"
    run(archive, out)
    outcome = run(archive, out, settings=Settings(completeness=1.0))["bob/run.c3d"]
    assert outcome.was_there and outcome.outcome == PARTLY and "% of its markers" in outcome.message
    assert rows_of(out)["bob/run.c3d"]["outcome"] == PARTLY


@pytest.mark.parametrize(("fit", "doubtful"), [(0.7949, True), (0.8, False), (None, False)])
def test_a_model_that_fits_badly_is_said_and_harms_nothing(archive, tmp_path, labeller, monkeypatch, fit, doubtful):
    def label_many(recordings, models, settings):
        for recording, model in zip(recordings, models, strict=True):
            labelling = make_labelling(recording, list(model.markers))
            yield replace(labelling, stats={"svd_count": 12} | ({} if fit is None else {"model_fit": fit}))

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
    for was_there in (False, True):
        outcome = run(archive, tmp_path / "out")["bob/run.c3d"]
        assert (outcome.was_there, outcome.outcome) == (was_there, LABELLED)
        assert ("only 79% of the usual evidence" in outcome.message) == doubtful == bool(outcome.message)
    with (tmp_path / "out" / "summary.csv").open() as file:
        row = next(row for row in csv.DictReader(file) if row["output"] == "bob/run.c3d")
    assert row["model_fit"] == ("" if fit is None else str(fit)) and bool(row["message"]) == doubtful


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

    def slowly(labelling, path):
        write(labelling, path)
        if path.name == "run.c3d":
            target.write_bytes(b"somebody's only copy")

    monkeypatch.setattr(io, "write_labelled", slowly)
    assert run(archive, tmp_path / "out")["bob/run.c3d"].outcome == KEPT
    assert target.read_bytes() == b"somebody's only copy" and len(list(target.parent.iterdir())) == 1


def test_a_recording_that_changes_meanwhile(archive, tmp_path, labeller, monkeypatch):
    write = io.write_labelled

    def slowly(labelling, path):
        write(labelling, path)
        with labelling.recording.source.open("ab") as file:
            file.write(b"more")

    monkeypatch.setattr(io, "write_labelled", slowly)
    outcome = run(archive / "bob", tmp_path / "out")["run.c3d"]
    assert outcome.outcome == FAILED and "run.c3d: changed while it was labelled" in outcome.message
    assert not (tmp_path / "out" / "run.c3d").exists() and not (tmp_path / "out" / "run.labels.json").exists()


def test_what_a_killed_run_left_is_cleared_away(archive, tmp_path, labeller):
    left, other = (tmp_path / "out" / "bob" / name for name in (".run.c3d.abcd_123.part", ".tin.c3d.abcd_123.part"))
    for folder in (left, other):
        folder.mkdir(parents=True)
        (folder / "run.c3d").write_bytes(b"half")
    run(archive, tmp_path / "out")
    assert not left.exists() and other.exists()


def rows_of(out: Path) -> dict[str, dict]:
    """The manifest; each file has one row, there and in the summary."""
    rows = [json.loads(line) for line in (out / "manifest.jsonl").read_text().splitlines()]
    with (out / "summary.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [row["input"] for row in table] == [row["input"] for row in rows]
    assert len({row["input"] for row in rows}) == len(rows)
    return {row["output"] or row["input"]: row for row in rows}


def test_shards_are_all_of_it(archive, tmp_path, labeller):
    jobs = find_jobs([archive], (), tmp_path / "out")
    shards = [in_shard(jobs, (k, 3)) for k in range(3)]
    assert sorted((job for shard in shards for job in shard), key=str) == sorted(jobs, key=str)
    (archive / "ann" / "walk.c3d").unlink()  # which share a file is in does not depend on others
    fewer = find_jobs([archive], (), tmp_path / "out")
    assert [in_shard(fewer, (k, 3)) for k in range(3)] == [[j for j in s if j in fewer] for s in shards]


def test_shards_write_one_manifest(archive, tmp_path, labeller):
    whole, shared = tmp_path / "whole", tmp_path / "shared"
    run(archive, whole)
    jobs = find_jobs([archive], (), shared)
    running = [label_archive(in_shard(jobs, (k, 2)), Order(shared, shard=(k, 2))) for k in range(2)]
    for outcomes in itertools.zip_longest(*running):  # side by side
        assert outcomes
    assert rows_of(shared).keys() == rows_of(whole).keys()
    of_the_run = ("manifest", "report.html", "summary.csv")
    for name, content in contents(whole).items():
        assert name.startswith(of_the_run) or (shared / name).read_bytes() == content
    assert set(contents(shared)) - set(contents(whole)) == {f"manifest-shards/{k}-of-2.jsonl" for k in range(2)}
    assert all(o.was_there or o.outcome == FAILED for o in run(archive, shared).values())


def test_a_manifest_that_was_cut_off_or_lost(archive, tmp_path, labeller):
    out = tmp_path / "out"
    run(archive, out)
    rows = rows_of(out)
    manifest = out / "manifest.jsonl"
    manifest.write_bytes(manifest.read_bytes()[:-100])
    run(archive, out)
    assert rows_of(out).keys() == rows.keys()
    manifest.unlink()
    run(archive, out)
    assert rows_of(out).keys() == rows.keys() and rows_of(out)["bob/run.c3d"]["frames"] == 22


def test_rows_of_what_is_gone_go_too(archive, tmp_path, labeller):
    out = tmp_path / "out"
    run(archive, out)
    (archive / "eve" / "jump.c3d").unlink()  # never had a result
    (archive / "bob" / "run.c3d").unlink()
    run(archive, out)
    assert sorted(rows_of(out)) == ["ann/day 2/walk.c3d", "ann/walk.c3d", "bob/run.c3d"]


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


def test_results_inside_an_input_are_no_input(archive, labeller):
    out = archive / "labelled"
    first = run(archive, out)
    assert run(archive, out).keys() == first.keys()


def test_two_recordings_with_one_result(archive, tmp_path):
    path = archive / "ann" / "walk.trc"
    path.write_text("")
    problems = {j.source.name: j.problem for j in find_jobs([archive / "ann"], (), tmp_path / "out")}
    assert problems["walk.c3d"] == "" and "would overwrite that of" in problems["walk.trc"]


def test_two_recordings_with_one_result_have_a_row_each(archive, tmp_path, labeller):
    (archive / "ann" / "walk.trc").write_text("")
    run(archive, tmp_path / "out")
    rows = rows_of(tmp_path / "out")
    assert rows["ann/walk.c3d"]["outcome"] == LABELLED
    assert rows[str(archive / "ann" / "walk.trc")]["outcome"] == FAILED


def test_a_folder_that_cannot_be_searched(archive, tmp_path, monkeypatch):
    scan = os.scandir

    def closed(path):
        if Path(path).name == "ann":
            raise PermissionError(13, "Permission denied", str(path))
        return scan(path)

    monkeypatch.setattr(os, "scandir", closed)
    problems = {j.source.name: j.problem for j in find_jobs([archive], (), tmp_path / "out")}
    assert "cannot be searched (Permission denied)" in problems["ann"] and problems["run.c3d"] == ""


def test_a_file_given_twice_is_labelled_once(archive, tmp_path):
    assert len(find_jobs([archive / "bob", archive / "bob" / "run.c3d"], (), tmp_path / "out")) == 1


def test_few_labels_are_not_success(archive, tmp_path, labeller):
    io.write_model(make_model([*MARKERS, *"ABCDEF"]), archive / "bob" / "model.json")
    outcome = run(archive, tmp_path / "out")["bob/run.c3d"]
    assert outcome.outcome == PARTLY and not outcome.ok and "% of its markers" in outcome.message
    assert (tmp_path / "out" / "bob" / "run.c3d").exists()


def test_a_result_that_cannot_be_written(archive, tmp_path, labeller, monkeypatch):
    def refuse(labelling, path):
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


def test_batches_are_bounded(tmp_path, labeller):
    folder = tmp_path / "archive"
    folder.mkdir()
    for k in range(20):
        io.write_c3d(make_recording(10, seed=k), folder / f"{k:02}.c3d")
    io.write_model(make_model(MARKERS), folder / "model.json")
    outcomes = run(folder, tmp_path / "out")
    assert labeller == [8, 8, 4] and list(outcomes) == [f"{k:02}.c3d" for k in range(20)]
    assert np.all([o.ok for o in outcomes.values()])


def test_several_subjects_in_one_recording(archive, tmp_path, labeller):
    io.write_model(make_model(["LASI", "NOSE"]), archive / "ann.json")
    models = [archive / "bob" / "model.json", archive / "ann.json"]
    out = tmp_path / "out"
    (outcome,) = label_archive(find_jobs([archive / "bob" / "run.c3d"], models, out), Order(out))
    assert outcome.figures["completeness"] == 0  # the stand-in looks for names without a subject
    assert io.read_sidecar_head(out / "run.labels.json")["markers"] == [
        *(f"bob:{marker}" for marker in MARKERS),
        "ann:LASI",
        "ann:NOSE",
    ]
    with pytest.raises(UsageError, match="two of the models are of a subject called 'ann'"):
        find_jobs([archive], [archive / "ann" / "model.json", archive / "ann.json"], out)
