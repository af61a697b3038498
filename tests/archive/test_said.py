"""What persons corrected: a result is made again around it, and nothing ever loses it."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest
from making import make_labelling, make_recording
from running import contents, run

from dshpm_jax import KnownLabel, Reason, io
from dshpm_jax._archive import FAILED, LABELLED
from dshpm_jax._archive.completeness import Lives, completeness
from dshpm_jax._corrections import Change, Correction, append, corrections_path, read_corrections

RUN = "bob/run.c3d"


@pytest.fixture
def told(monkeypatch):
    """What the labeller was told to know, by the number of frames of the recording."""
    found = {}

    def label_many(recordings, models, settings, known):
        for recording, model, labels in zip(recordings, models, known, strict=True):
            found[recording.num_frames] = tuple(labels)
            labelling = make_labelling(recording, list(model.markers))
            labelling.stats["against"] = [f"{one}, which nobody believes" for one in labels if one.label == "SACR"]
            yield labelling

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
    return found


def correct(archive, out, *changes: Change, **fields) -> Correction:
    correction = Correction(fields.pop("kind", "label"), changes, **fields)
    append(corrections_path(out / RUN), correction, archive / RUN)
    return correction


def made_again(archive, out, **order) -> set[str]:
    return {name for name, o in run(archive, out, **order).items() if o.ok and not o.was_there}


def test_a_result_is_made_again_around_a_correction_and_then_up_to_date(archive, tmp_path, told):
    out = tmp_path / "out"
    run(archive, out)
    assert not any(told.values()) and "corrections" not in (io.read_sidecar_head(out / "bob/run.labels.json") or {})
    one = correct(archive, out, Change(1, 0, 9, "LASI", "RASI"), Change(0, 0, 9, "RASI", "LASI"))
    kept = corrections_path(out / RUN).read_bytes()
    assert made_again(archive, out) == {RUN}
    assert told[22] == (KnownLabel(0, 0, 9, "RASI"), KnownLabel(1, 0, 9, "LASI"))
    head = io.read_sidecar_head(out / "bob/run.labels.json") or {}
    assert head["corrections"] == [one.id] and head["known"] == [[0, 0, 8, "RASI"], [1, 0, 8, "LASI"]]
    assert made_again(archive, out) == set()
    told.clear()
    assert made_again(archive, out, force=True) == {"ann/walk.c3d", "ann/day 2/walk.c3d", RUN}
    assert len(told[22]) == 2 and corrections_path(out / RUN).read_bytes() == kept
    correct(archive, out, kind="undo", of=one.id)
    assert made_again(archive, out) == {RUN} and told[22] == ()


def test_a_result_that_is_gone_is_made_again_with_what_was_corrected(archive, tmp_path, told):
    out = tmp_path / "out"
    run(archive, out)
    correct(archive, out, Change(2, 0, 22, None))
    for path in (out / RUN, io.sidecar_path(out / RUN)):
        path.unlink()
    run(archive, out)
    assert told[22] == (KnownLabel(2, 0, 22, None),)


def test_what_does_not_fit_any_more_is_said(archive, tmp_path, told):
    out = tmp_path / "out"
    run(archive, out)
    correct(archive, out, Change(0, 0, 9, "C7"), Change(1, 0, 9, "SACR"), Change(9, 0, 9, "LASI"))
    outcome = run(archive, out)[RUN]
    assert told[22] == (KnownLabel(0, 0, 9, None), KnownLabel(1, 0, 9, "SACR"))
    said = " | ".join(outcome.notes)
    assert "corrections say C7, which are no markers of the model" in said
    assert "1 corrections are of columns that are left out" in said
    assert "column 1, frames 0 to 8: SACR, which nobody believes" in said


def test_a_damaged_file_fails_its_result_alone_and_stays(archive, tmp_path, told):
    out = tmp_path / "out"
    run(archive, out)
    before = contents(out)[RUN]
    path = corrections_path(out / RUN)
    path.write_text("nonsense\n")
    for order in ({}, {"force": True}):
        outcomes = run(archive, out, **order)
        assert outcomes[RUN].outcome == FAILED and "\n" not in outcomes[RUN].message
        assert "run.corrections.jsonl: line 1 cannot be understood" in outcomes[RUN].message
        assert outcomes["ann/walk.c3d"].outcome == LABELLED
    assert contents(out)[RUN] == before and path.read_text() == "nonsense\n"


def test_corrections_of_another_recording_are_refused(archive, tmp_path, told):
    out = tmp_path / "out"
    run(archive, out)
    correct(archive, out, Change(0, 0, 9, "SACR"))
    io.write_c3d(make_recording(22, seed=77), archive / RUN)
    told.clear()
    outcome = run(archive, out)[RUN]
    assert outcome.outcome == FAILED and "has other points" in outcome.message and 22 not in told
    assert read_corrections(corrections_path(out / RUN)) is not None


def test_points_that_are_known_to_be_no_marker_are_not_missed():
    found = make_labelling(make_recording(30), ["LASI", "RASI", "SACR", "T10"])
    none = found.identity == -1
    known = replace(found, reason=tuple(Reason.KNOWN if n else r for n, r in zip(none, found.reason)))
    assert completeness(Lives.of(found)) < completeness(Lives.of(known)) == 1.0
    assert completeness(Lives.of_sidecar(io.sidecar(known))) == 1.0
    assert none.any()
