"""The page of a run says what manifest and sidecars say, whatever the names are."""

import json
import os

import numpy as np
import pytest
from browser import assert_self_contained, data_of, needs_browser, shown
from making import make_labelling, make_recording

from dshpm_jax import Labelling, Recording, io
from dshpm_jax._labelling import Reason
from dshpm_jax.report._page import GENERATOR
from dshpm_jax.report._run_page import PAGE_NAME, write_run_page

EVIL = "</script><img src=x onerror=alert(1)>&'\""


def labelling_of(recording: Recording, markers: list[str], confidence: float) -> Labelling:
    found = make_labelling(recording, markers)
    found.confidence[:] = confidence
    return found


def add_result(out, name: str, labelling: Labelling, **row) -> dict:
    """Writes a result and gives its row of the manifest."""
    target = out / name
    target.parent.mkdir(parents=True, exist_ok=True)
    io.write_labelled(labelling, target)
    io.write_sidecar(labelling, target.with_name(f"{target.stem}.labels.json"))
    return {
        "input": f"/captures/{name}",
        "output": name,
        "outcome": "labelled",
        "completeness": 0.9,
        "frames": 20,
    } | row


def page_of(out, rows) -> str:
    write_run_page(out, rows)
    return (out / PAGE_NAME).read_text()


@pytest.fixture
def gapped() -> Recording:
    """A is seen throughout, B with gaps of 2 and 5 frames, C never, and one point is nobody's."""
    recording = make_recording(20, ("A", "B", "C", "*1"), rate=10.0)
    points = recording.points
    points[:] = 1.0
    points[4:6, 1] = points[10:15, 1] = points[:, 2] = float("nan")
    return recording


def test_what_it_counts(gapped, tmp_path):
    row = add_result(tmp_path, "ann/walk.c3d", labelling_of(gapped, ["A", "B", "C"], 0.95), seconds=0.25)
    data = data_of(page_of(tmp_path, [row]))
    (file,) = data["files"]
    assert file["name"] == "ann/walk.c3d" and file["link"] == "ann/walk.c3d" and file["page"] is None
    assert file["confidence"] == 0.95 and file["seconds"] == 0.25 and file["suspects"] == 0
    a, b, c = data["markers"]
    assert (a["label"], a["found"], a["gaps"], a["longest"], a["confidence"]) == ("A", 1.0, 0, 0, 0.95)
    assert (b["label"], b["found"], b["gaps"], b["longest"], b["absent"]) == ("B", 0.65, 2, 0.5, 0)
    assert (c["label"], c["found"], c["gaps"], c["confidence"], c["absent"]) == ("C", 0.0, 0, None, 1)


def test_labels_over_several_files(gapped, tmp_path):
    rows = [
        add_result(tmp_path, "1.c3d", labelling_of(gapped, ["A", "B"], 1.0)),
        add_result(tmp_path, "2.c3d", labelling_of(gapped.frames(0, 10), ["A", "C"], 0.97)),
    ]
    markers = {row["label"]: row for row in data_of(page_of(tmp_path, rows))["markers"]}
    assert markers["A"]["files"] == 2 and markers["A"]["confidence"] == 0.99
    assert markers["B"]["files"] == 1 and markers["C"]["absent"] == 1


def test_labels_to_look_at(gapped, tmp_path):
    labelling = labelling_of(gapped, ["A", "B"], 0.95)
    labelling.confidence[0] = 0.75  # A: 2 s of which a quarter is at stake
    reasons = list(labelling.reason)
    (nobody,) = (j for j, reason in enumerate(reasons) if reason == Reason.OUTSIDE)
    reasons[nobody], labelling.confidence[nobody] = Reason.AMBIGUOUS, 0.6
    object.__setattr__(labelling, "reason", tuple(reasons))
    could_be = np.full((len(reasons), 2), -1)
    could_be[0, 0], could_be[nobody] = 1, [1, 0]
    object.__setattr__(labelling, "could_be", could_be)
    data = data_of(page_of(tmp_path, [add_result(tmp_path, "walk.c3d", labelling)]))
    assert [(s["label"], s["stake"]) for s in data["suspects"]] == [(None, 0.8), ("A", 0.5)]
    assert data["suspects"][1]["first"] == 0 and data["suspects"][1]["last"] == 19 and data["all_suspects"] == 2
    assert data["files"][0]["suspects"] == 2
    assert [s["could_be"] for s in data["suspects"]] == [["B", "A"], ["B"]]


def test_files_without_a_result(tmp_path):
    failed = {"input": "/captures/bad.c3d", "output": "bad.c3d", "outcome": "failed", "message": "bad.c3d: is empty"}
    data = data_of(page_of(tmp_path, [failed]))
    assert data["files"][0]["message"] == "bad.c3d: is empty" and data["files"][0]["link"] is None
    assert data["markers"] == [] and data["suspects"] == []
    clash = {"input": "/captures/bad.trc", "output": None, "outcome": "failed", "message": "would overwrite"}
    (row,) = data_of(page_of(tmp_path, [clash]))["files"]
    assert row["name"] == "/captures/bad.trc" and row["link"] is None and row["page"] is None


def test_a_broken_sidecar_is_none(gapped, tmp_path):
    row = add_result(tmp_path, "walk.c3d", labelling_of(gapped, ["A"], 1.0))
    (tmp_path / "walk.labels.json").write_text("{")
    assert data_of(page_of(tmp_path, [row]))["files"][0]["confidence"] is None


def test_names_may_hold_anything(gapped, tmp_path):
    recording = Recording(gapped.points, (EVIL, "B", "C", "*1"), 10.0)
    row = add_result(tmp_path, "a #1 %2F?.c3d", labelling_of(recording, [EVIL, "B"], 0.5))
    page = page_of(tmp_path, [row, {"output": f"{EVIL}.c3d", "outcome": EVIL, "message": EVIL, "input": EVIL}])
    assert_self_contained(page)
    data = data_of(page)
    assert data["markers"][0]["label"] == EVIL and data["files"][1]["message"] == EVIL
    assert data["files"][0]["link"] == "a%20%231%20%252F%3F.c3d"


def test_it_links_to_pages_that_are_there(gapped, tmp_path):
    row = add_result(tmp_path, "ann/walk.c3d", labelling_of(gapped, ["A"], 1.0))
    page = tmp_path / "ann" / "walk.html"
    page.write_text(GENERATOR)
    assert data_of(page_of(tmp_path, [row]))["files"][0]["page"] == "ann/walk.html"
    os.utime(page, (1, 1))  # the recording was labelled again since
    assert data_of(page_of(tmp_path, [row]))["files"][0]["page"] is None
    page.write_text("notes of somebody's own")
    assert data_of(page_of(tmp_path, [row]))["files"][0]["page"] is None


def test_same_run_same_page(gapped, tmp_path):
    row = add_result(tmp_path, "walk.c3d", labelling_of(gapped, ["A"], 0.5))
    assert page_of(tmp_path, [row]) == page_of(tmp_path, [json.loads(json.dumps(row))])


def test_what_is_no_page_of_ours_stays(tmp_path):
    (tmp_path / PAGE_NAME).write_text("my own report")
    with pytest.raises(io.WriteError, match="no page of ours, not overwritten"):
        write_run_page(tmp_path, [])
    assert (tmp_path / PAGE_NAME).read_text() == "my own report"


@needs_browser
def test_a_browser_shows_it(gapped, tmp_path):
    labelling = labelling_of(gapped, ["A", "B"], 0.85)
    object.__setattr__(labelling, "could_be", np.tile([1, 0], (len(labelling.trajectories), 1)))
    row = add_result(tmp_path, "walk.c3d", labelling, seconds=2.0)
    failed = {"input": EVIL, "output": "bad.c3d", "outcome": "failed", "message": EVIL}
    write_run_page(tmp_path, [row, failed])
    page = shown(tmp_path / PAGE_NAME, tmp_path / "profile")
    assert "FAILED" not in page and "onerror=alert(1)&gt;&amp;" in page
    assert page.index(">bad.c3d<") < page.index('href="walk.c3d"')  # the worst first
    assert ">Could be<" in page and "<td>B or A</td>" in page
    assert page.count("<tr>") == 3 + 2 + 4 + 2  # heads; files, labels to look at (A, and three stretches of B), markers
