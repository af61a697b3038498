"""Runs that go on where others ended, or share the work: what is made again, and one row a file."""

import itertools
import json
import os
from pathlib import Path

from making import make_model, make_recording
from running import MARKERS, contents, rows_of, run
from text_files import TRC

from dshpm_jax import io
from dshpm_jax._archive import FAILED, LABELLED, PARTLY, Order, find_jobs, in_shard, label_archive
from dshpm_jax._settings import Settings


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
    assert outcome.was_there and outcome.outcome == PARTLY and "% of the points of its markers" in outcome.message
    assert rows_of(out)["bob/run.c3d"]["outcome"] == PARTLY


def test_a_result_of_an_earlier_version_is_judged_anew_without_labelling(archive, tmp_path, labeller):
    """It held completeness of all frames, and nothing of markers that are never seen."""
    out = tmp_path / "out"
    run(archive, out)
    sidecar = out / "bob" / "run.labels.json"
    lines = sidecar.read_text().splitlines(keepends=True)
    (place,) = (k for k, line in enumerate(lines) if line.startswith(' "figures"'))
    figures = json.loads("{" + lines[place].rstrip(",\n") + "}")["figures"]
    now = {name: figures.pop(name) for name in ("never_seen", "doubts")} | {"completeness": figures["completeness"]}
    lines[place] = f' "figures": {json.dumps(figures | {"completeness": 0.123})},\n'
    sidecar.write_text("".join(lines))
    rows = [json.loads(line) for line in (out / "manifest.jsonl").read_text().splitlines()]
    for row in rows:
        if row["output"] == "bob/run.c3d":
            del row["never_seen"], row["doubts"]
            row["completeness"] = 0.123
    (out / "manifest.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    labeller.clear()
    outcome = run(archive, out)["bob/run.c3d"]
    assert outcome.was_there and outcome.outcome == LABELLED and not labeller
    assert {name: rows_of(out)["bob/run.c3d"][name] for name in now} == now


def test_what_a_killed_run_left_is_cleared_away(archive, tmp_path, labeller):
    left, other = (tmp_path / "out" / "bob" / name for name in (".run.c3d.abcd_123.part", ".tin.c3d.abcd_123.part"))
    for folder in (left, other):
        folder.mkdir(parents=True)
        (folder / "run.c3d").write_bytes(b"half")
    run(archive, tmp_path / "out")
    assert not left.exists() and other.exists()


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


def test_rows_of_troubles_that_are_over_go(archive, tmp_path, labeller, monkeypatch):
    out, twin, empty = tmp_path / "out", archive / "ann" / "walk.trc", archive / "bob" / "later"
    twin.write_text(TRC)
    empty.mkdir()
    scan = os.scandir
    with monkeypatch.context() as locked:
        locked.setattr(os, "scandir", lambda path: refuse(path) if Path(path).name == "eve" else scan(path))
        run(archive, out)
    rows_before = rows_of(out)
    run(empty, out)
    assert {rows_of(out)[key]["outcome"] for key in (str(twin), "eve", "later")} == {FAILED}

    (archive / "ann" / "walk.c3d").unlink()
    io.write_c3d(make_recording(20), empty / "run.c3d")
    for _ in range(2):
        run(archive, out)
        rows = rows_of(out)
        assert rows["ann/walk.c3d"]["input"] == str(twin) and rows["ann/walk.c3d"]["outcome"] == LABELLED
        assert set(rows) == {*rows_before, "bob/later/run.c3d", "eve/jump.c3d"} - {str(twin), "eve"}


def refuse(path):
    raise PermissionError(13, "Permission denied", str(path))


def test_results_inside_an_input_are_no_input(archive, labeller):
    out = archive / "labelled"
    first = run(archive, out)
    assert run(archive, out).keys() == first.keys()
