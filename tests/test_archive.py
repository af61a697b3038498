"""Runs over folders: what is found, what is written, and that one file's trouble stays its own."""

import hashlib
import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from making import make_labelling, make_model, make_recording

from dshpm_jax import io
from dshpm_jax._archive import FAILED, KEPT, LABELLED, PARTLY, UP_TO_DATE, UsageError, find_jobs, label_archive
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


def run(archive, out, force=False, settings=None):
    outcomes = list(label_archive(find_jobs([archive], (), out), out, settings or Settings(), force))
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
    assert {o.outcome for o in run(archive, out).values()} == {UP_TO_DATE, FAILED}
    assert contents(out) == first

    io.write_c3d(make_recording(30, seed=9), archive / "bob" / "run.c3d")
    (out / "ann" / "walk.c3d").unlink()
    outcomes = run(archive, out)
    assert outcomes["ann/walk.c3d"].outcome == LABELLED
    assert outcomes["bob/run.c3d"].outcome == KEPT and "--force" in outcomes["bob/run.c3d"].message
    assert contents(out)["ann/walk.c3d"] == first["ann/walk.c3d"]
    assert contents(out)["bob/run.c3d"] == first["bob/run.c3d"]

    assert run(archive, out, force=True)["bob/run.c3d"].outcome == LABELLED
    assert io.read(out / "bob" / "run.c3d").num_frames == 30
    changed = run(archive, out, settings=Settings(method="paper"))
    assert changed["bob/run.c3d"].outcome == KEPT
    assert len((out / "manifest.jsonl").read_text().splitlines()) == 4


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
    assert [n for n in contents(tmp_path / "out") if n != "manifest.jsonl"] == []


def test_batches_are_bounded(tmp_path, labeller):
    folder = tmp_path / "archive"
    folder.mkdir()
    for k in range(20):
        io.write_c3d(make_recording(10, seed=k), folder / f"{k:02}.c3d")
    io.write_model(make_model(MARKERS), folder / "model.json")
    outcomes = run(folder, tmp_path / "out")
    assert labeller == [16, 4] and list(outcomes) == [f"{k:02}.c3d" for k in range(20)]
    assert np.all([o.ok for o in outcomes.values()])


def test_several_subjects_in_one_recording(archive, tmp_path, labeller):
    io.write_model(make_model(["LASI", "NOSE"]), archive / "ann.json")
    models = [archive / "bob" / "model.json", archive / "ann.json"]
    out = tmp_path / "out"
    (outcome,) = label_archive(find_jobs([archive / "bob" / "run.c3d"], models, out), out, Settings())
    assert outcome.figures["completeness"] == 0  # the stand-in looks for names without a subject
    assert io.read_sidecar_head(out / "run.labels.json")["markers"] == [
        *(f"bob:{marker}" for marker in MARKERS),
        "ann:LASI",
        "ann:NOSE",
    ]
    with pytest.raises(UsageError, match="two of the models are of a subject called 'ann'"):
        find_jobs([archive], [archive / "ann" / "model.json", archive / "ann.json"], out)
