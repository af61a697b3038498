"""Runs over folders: what is found, what is written, and that one file's trouble stays its own."""

import csv
import hashlib
import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from making import make_labelling, make_model, make_recording
from running import MARKERS, contents, rows_of, run

from dshpm_jax import io
from dshpm_jax._archive import DOUBTFUL, FAILED, LABELLED, PARTLY, PASSED, Order, find_jobs, label_archive
from dshpm_jax._archive.compiling import ONCE
from dshpm_jax._messages import UsageError


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
    assert labeller == [3, 1, 1, 1]  # an empty file alone, four of which one is broken, one by one where one fails, one
    assert not (tmp_path / "out" / "ann" / "odd.c3d").exists()


def test_a_broken_model_harms_its_own_recordings_only(archive, tmp_path, labeller):
    (archive / "bob" / "model.json").write_text("{}")
    outcomes = run(archive, tmp_path / "out")
    assert outcomes["bob/run.c3d"].outcome == FAILED and "no marker model" in outcomes["bob/run.c3d"].message
    assert outcomes["ann/walk.c3d"].ok


@pytest.mark.parametrize(("fit", "doubtful"), [(0.7949, True), (0.8, False), (None, False)])
def test_labels_of_a_model_that_fits_badly_are_doubtful(archive, tmp_path, labeller, monkeypatch, fit, doubtful):
    def label_many(recordings, models, settings, known):
        for recording, model in zip(recordings, models, strict=True):
            labelling = make_labelling(recording, list(model.markers))
            yield replace(labelling, stats={"svd_count": 12} | ({} if fit is None else {"model_fit": fit}))

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
    for was_there in (False, True):
        outcome = run(archive, tmp_path / "out")["bob/run.c3d"]
        assert (outcome.was_there, outcome.outcome) == (was_there, DOUBTFUL if doubtful else LABELLED)
        assert outcome.ok != doubtful and (tmp_path / "out" / "bob" / "run.c3d").exists()
        assert ("only 79% of the usual evidence" in outcome.message) == doubtful == bool(outcome.message)
    with (tmp_path / "out" / "summary.csv").open() as file:
        row = next(row for row in csv.DictReader(file) if row["output"] == "bob/run.c3d")
    assert row["model_fit"] == ("" if fit is None else str(fit)) and bool(row["message"]) == doubtful


def test_files_without_points_are_passed_over(archive, tmp_path, labeller, monkeypatch):
    read = io.read

    def of_emg(path, *more):
        if Path(path).name == "run.c3d":
            raise io.NoPoints(path, "it holds analog samples alone", "give recordings with points")
        return read(path, *more)

    monkeypatch.setattr(io, "read", of_emg)
    outcomes = run(archive, tmp_path / "out")
    outcome = outcomes["bob/run.c3d"]
    assert outcome.outcome == PASSED and outcome.ok and outcome.message.endswith("with points (passed over)")
    assert rows_of(tmp_path / "out")["bob/run.c3d"]["outcome"] == PASSED
    assert outcomes["ann/walk.c3d"].outcome == LABELLED and not (tmp_path / "out" / "bob").exists()


def test_reasons_of_doubt_stand_in_the_row(archive, tmp_path, labeller, monkeypatch):
    def label_many(recordings, models, settings, known):
        for recording, model in zip(recordings, models, strict=True):
            yield replace(make_labelling(recording, list(model.markers)), stats={"doubts": ["its axes are mirrored"]})

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
    for _ in range(2):
        outcome = run(archive, tmp_path / "out")["bob/run.c3d"]
        assert outcome.outcome == DOUBTFUL and "run.c3d: doubtful, its axes are mirrored; check it" in outcome.message
        assert rows_of(tmp_path / "out")["bob/run.c3d"]["doubts"] == ["its axes are mirrored"]


def test_a_result_and_its_row_are_there_before_the_next_is_labelled(archive, tmp_path, monkeypatch):
    out, before = tmp_path / "out", []

    def label_many(recordings, models, settings, known):
        for recording, model in zip(recordings, models, strict=True):
            rows = (out / "manifest.jsonl").read_text().splitlines()
            before.append((len(list(out.rglob("*.labels.json"))), sum('"labelled"' in row for row in rows)))
            yield make_labelling(recording, list(model.markers))

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
    run(archive, out)
    assert before == [(0, 0), (1, 1), (2, 2)]


def test_what_is_going_on_is_told(archive, tmp_path, labeller, monkeypatch):
    monkeypatch.setattr("dshpm_jax._archive.compiling.cache_folder", lambda: tmp_path / "empty")
    (tmp_path / "empty").mkdir()
    lines = []
    run(archive, tmp_path / "out", notice=lines.append)
    first, then = (["reading " + files, "labelling " + files, ONCE] for files in ("1 file", "2 files"))
    assert lines == [*first, *then]


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


def test_linked_folders_are_searched_once(archive, tmp_path):
    (tmp_path / "store").mkdir()
    (archive / "bob").rename(tmp_path / "store" / "bob")
    out = tmp_path / "out"
    out.mkdir()
    try:
        for name, target in {
            "bob": tmp_path / "store" / "bob",  # elsewhere
            "again": tmp_path / "store" / "bob",
            "ann/up": archive,
            "ann/out": out,
            "all": tmp_path,
        }.items():
            (archive / name).symlink_to(target, target_is_directory=True)
        (archive / "a first name.c3d").symlink_to(archive / "ann" / "walk.c3d")
    except OSError:
        pytest.skip("no links can be made here")
    io.write_c3d(make_recording(10), out / "result.c3d")
    places = [job.target.as_posix() for job in find_jobs([archive, archive / "ann" / "walk.c3d"], (), out)]
    assert sorted(places) == ["again/run.c3d", "ann/day 2/walk.c3d", "ann/walk.c3d", "eve/jump.c3d"]


def test_few_labels_are_not_success(archive, tmp_path, labeller):
    io.write_model(make_model(["LASI", "A", "B", "C"]), archive / "bob" / "model.json")
    outcome = run(archive, tmp_path / "out")["bob/run.c3d"]
    assert outcome.outcome == PARTLY and not outcome.ok and "% of the points of its markers" in outcome.message
    assert (tmp_path / "out" / "bob" / "run.c3d").exists()


@pytest.fixture
def twenty(tmp_path):
    folder = tmp_path / "archive"
    folder.mkdir()
    for k in range(20):
        io.write_c3d(make_recording(10, seed=k), folder / f"{k:02}.c3d")
    io.write_model(make_model(MARKERS), folder / "model.json")
    return folder


def test_batches_are_bounded(twenty, tmp_path, labeller):
    outcomes = run(twenty, tmp_path / "out")
    assert labeller == [1, 4, 15] and list(outcomes) == [f"{k:02}.c3d" for k in range(20)]
    assert np.all([o.ok for o in outcomes.values()])


def test_batches_of_several_workers_grow_smaller(twenty, tmp_path, labeller):
    """A worker that has nothing left waits only for small batches of the others; the first results are soon there."""
    outcomes = run(twenty, tmp_path / "out", workers=2)
    assert labeller == [1, 1, 4, 4, 3, 2, 2, 1, 1, 1] and len(outcomes) == 20


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
