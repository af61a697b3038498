"""The page of a run says what manifest and sidecars say, whatever the names are, and stays small."""

import json
import os
from dataclasses import replace

import numpy as np
import pytest
from browser import assert_self_contained, data_of, needs_browser, shown
from making import make_labelling, make_recording

from dshpm_jax import Labelling, Recording, io
from dshpm_jax._corrections import Correction, append, corrections_path
from dshpm_jax._labelling import Reason
from dshpm_jax.report._page import GENERATOR
from dshpm_jax.report._page_name import PAGE_NAME
from dshpm_jax.report._run_page import write_run_page

EVIL = "</script><img src=x onerror=alert(1)>&'\""
FIELDS = "name outcome stake doubts confidence completeness frames labelled trajectories seconds more".split()
MOST_BYTES = 5_000_000


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


def trials_of(data: dict) -> list[dict]:
    return [dict(zip(FIELDS, trial, strict=True)) for trial in data["trials"]]


def test_what_persons_said_is_told(tmp_path):
    found = labelling_of(make_recording(20), ["LASI", "RASI", "SACR"], 0.99)
    reason = (Reason.KNOWN, *found.reason[1:])
    rows = [add_result(tmp_path, "walk.c3d", replace(found, reason=reason)), add_result(tmp_path, "run.c3d", found)]
    source = tmp_path / "raw.c3d"
    io.write_c3d(found.recording, source)
    append(corrections_path(tmp_path / "walk.c3d"), Correction("confirm", whole=True), source)
    corrections_path(tmp_path / "run.c3d").write_text("nonsense")
    trials = {trial["name"]: trial["more"].get("said") for trial in trials_of(data_of(page_of(tmp_path, rows)))}
    assert trials == {"walk.c3d": "confirmed, 1 trajectory known", "run.c3d": None}


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
    (trial,) = trials_of(data)
    assert trial["name"] == "ann/walk.c3d" and trial["more"] == {} and trial["doubts"] == 0
    assert trial["confidence"] == 0.95 and trial["seconds"] == 0.25 and trial["stake"] == 0
    markers = {marker["label"]: marker for marker in data["markers"]}
    assert list(markers) == ["C", "B", "A"]  # the one found least first
    a, b, c = markers["A"], markers["B"], markers["C"]
    assert (a["found"], a["gaps"], a["longest"], a["confidence"]) == (1.0, 0, 0, 0.95)
    assert (b["found"], b["gaps"], b["longest"], b["absent"]) == (0.65, 2, 0.5, 0)
    assert (c["found"], c["gaps"], c["confidence"], c["absent"]) == (0.0, 0, None, 1)


def test_labels_over_several_files(gapped, tmp_path):
    rows = [
        add_result(tmp_path, "1.c3d", labelling_of(gapped, ["A", "B"], 1.0)),
        add_result(tmp_path, "2.c3d", labelling_of(gapped.frames(0, 10), ["A", "C"], 0.97)),
    ]
    markers = {row["label"]: row for row in data_of(page_of(tmp_path, rows))["markers"]}
    assert markers["A"]["files"] == 2 and markers["A"]["confidence"] == 0.99
    assert markers["B"]["files"] == 1 and markers["C"]["absent"] == 1


def test_doubts_in_seconds_with_their_causes(gapped, tmp_path):
    labelling = labelling_of(gapped, ["A", "B"], 0.95)
    labelling.confidence[0] = 0.75  # A, all of its 2 s
    reasons = list(labelling.reason)
    (nobody,) = (j for j, reason in enumerate(reasons) if reason == Reason.OUTSIDE)
    reasons[nobody], labelling.confidence[nobody] = Reason.AMBIGUOUS, 0.6
    could_be = np.full((len(reasons), 2), -1)
    could_be[0, 0], could_be[nobody] = 1, [1, 0]
    labelling = replace(labelling, reason=tuple(reasons), could_be=could_be)
    data = data_of(page_of(tmp_path, [add_result(tmp_path, "walk.c3d", labelling)]))
    (trial,) = trials_of(data)
    assert (trial["stake"], trial["doubts"]) == (4.0, 2) and data["all"]["stake"] == 4.0
    listed = [[*doubt[:5], data["causes"][doubt[5]], *doubt[6:]] for doubt in data["doubts"]["walk.c3d"]]
    assert listed == [
        ["A", 0, 19, 2.0, 0.75, "fits its place less well than right labels do", "B"],
        [None, 0, 19, 2.0, 0.4, "two labels fit almost equally well", "B", "A"],
    ]
    assert {marker["label"]: marker["stake"] for marker in data["markers"]} == {"A": 2.0, "B": 2.0}


def test_what_needs_somebody_comes_first(gapped, tmp_path):
    sure, unsure = labelling_of(gapped, ["A", "B"], 1.0), labelling_of(gapped, ["A", "B"], 0.8)
    rows = [
        add_result(tmp_path, "ann/1.c3d", sure),
        add_result(tmp_path, "ann/2.c3d", unsure),
        add_result(tmp_path, "ben/3.c3d", sure, outcome="partly labelled"),
        add_result(tmp_path, "ben/4.c3d", sure, outcome="doubtful", doubts=["its unit is off"], message="no matter"),
        {"input": "/captures/5.c3d", "output": "ben/5.c3d", "outcome": "failed", "message": "/captures/5.c3d: empty"},
        {"input": "/captures/6.c3d", "output": "ben/6.c3d", "outcome": "passed over", "message": "of no points"},
        {"input": "/captures/7.c3d", "output": "ben/7.c3d", "outcome": "of a later version"},
    ]
    data = data_of(page_of(tmp_path, rows))
    trials = trials_of(data)
    assert [trial["name"][4] for trial in trials] == list("7543216")
    assert trials[1]["more"] == {"why": ["empty"]} and trials[2]["more"] == {"why": ["its unit is off"]}
    subjects = {subject["name"]: subject for subject in data["subjects"]}
    assert list(subjects) == ["ann", "ben"] and subjects["ann"]["stake"] == trials[4]["stake"] > 0
    assert subjects["ben"]["outcomes"]["failed"] == 1 and subjects["ben"]["trials"] == 5


def test_files_without_a_result(tmp_path):
    failed = {"input": "/captures/bad.c3d", "output": "bad.c3d", "outcome": "failed", "message": "bad.c3d: is empty"}
    data = data_of(page_of(tmp_path, [failed]))
    assert data["trials"][0][-1] == {"why": ["is empty"]}
    assert data["markers"] == [] and data["doubts"] == {}
    clash = {"input": "/captures/bad.trc", "output": None, "outcome": "failed", "message": "would overwrite"}
    (row,) = trials_of(data_of(page_of(tmp_path, [clash])))
    assert row["name"] == "/captures/bad.trc" and row["more"] == {"why": ["would overwrite"]}


def test_a_broken_sidecar_is_none(gapped, tmp_path):
    row = add_result(tmp_path, "walk.c3d", labelling_of(gapped, ["A"], 1.0))
    (tmp_path / "walk.labels.json").write_text("{")
    assert trials_of(data_of(page_of(tmp_path, [row])))[0]["confidence"] is None


def test_names_may_hold_anything(gapped, tmp_path):
    recording = Recording(gapped.points, (EVIL, "B", "C", "*1"), 10.0)
    row = add_result(tmp_path, "a #1 %2F?.c3d", labelling_of(recording, [EVIL, "B"], 0.5))
    (tmp_path / "a #1 %2F?.html").write_text(GENERATOR)
    page = page_of(tmp_path, [row, {"output": f"{EVIL}.c3d", "outcome": EVIL, "message": EVIL, "input": EVIL}])
    assert_self_contained(page)
    trials = trials_of(data_of(page))
    assert trials[0]["more"]["why"] == [EVIL] and trials[0]["outcome"] == EVIL
    assert trials[1]["more"]["page"] == "a%20%231%20%252F%3F.html"


def test_it_links_to_pages_that_are_there(gapped, tmp_path):
    def link(name="ann/walk.c3d"):
        row = add_result(tmp_path, name, labelling_of(gapped, ["A"], 1.0))
        return lambda: trials_of(data_of(page_of(tmp_path, [row])))[0]["more"].get("page")

    found, page = link(), tmp_path / "ann" / "walk.html"
    page.write_text(GENERATOR)
    assert found() == 1  # the usual name
    os.utime(page, (1, 1))  # the recording was labelled again since
    assert found() is None
    page.write_text("notes of somebody's own")
    assert found() is None
    found = link("report.c3d")
    assert found() is None  # although there is a page of ours called report.html
    (tmp_path / "report.c3d.html").write_text(GENERATOR)
    assert found() == "report.c3d.html"


def test_same_run_same_page(gapped, tmp_path):
    row = add_result(tmp_path, "walk.c3d", labelling_of(gapped, ["A"], 0.5))
    assert page_of(tmp_path, [row]) == page_of(tmp_path, [json.loads(json.dumps(row))])


@pytest.mark.parametrize("name", ["walk", 100 * "<"])
def test_a_page_stays_small_whatever_the_archive(name, tmp_path):
    rows = [
        {"input": f"/{k}/{name}", "output": f"{k}/{name}.c3d", "outcome": "failed", "message": 500 * "\N{EURO SIGN}"}
        for k in range(5000)
    ]
    page = page_of(tmp_path, rows)
    data = data_of(page)
    assert MOST_BYTES / 4 < len(page.encode()) < MOST_BYTES
    assert 500 < len(data["trials"]) < 5000 == data["all"]["trials"] and len(data["subjects"]) < data["all_subjects"]
    assert [trial[0] for trial in data["trials"]] == sorted(row["output"] for row in rows)[: len(data["trials"])]


def test_what_is_no_page_of_ours_stays(tmp_path):
    (tmp_path / PAGE_NAME).write_text("my own report")
    with pytest.raises(io.WriteError, match="no page of ours, not overwritten"):
        write_run_page(tmp_path, [])
    assert (tmp_path / PAGE_NAME).read_text() == "my own report"


@needs_browser
def test_a_browser_shows_it(gapped, tmp_path):
    labelling = labelling_of(gapped, ["A", "B"], 0.85)
    labelling = replace(labelling, could_be=np.tile([1, 0], (len(labelling.trajectories), 1)))
    row = add_result(tmp_path, "ann/walk.c3d", labelling, seconds=2.0)
    (tmp_path / "ann" / "walk.html").write_text(GENERATOR)
    failed = {"input": EVIL, "output": "bad.c3d", "outcome": "failed", "message": EVIL}
    write_run_page(tmp_path, [row, failed])
    path = tmp_path / PAGE_NAME
    page = shown(path, tmp_path / "profile")
    assert "FAILED" not in page and "onerror=alert(1)&gt;&amp;" in page
    assert page.index("bad.c3d<") < page.index('href="ann/walk.html"')  # the worst first
    assert page.count("<tr>") + page.count('<tr class="folds">') == 3 + 2 + 2 + 2  # heads; trials, subjects, markers
    assert "may be B or A" not in page
    unfold = "<script>document.querySelector('.fold').click()</script></body>"
    path.write_text(path.read_text().replace("</body>", unfold))
    page = shown(path, tmp_path / "profile")
    assert 'href="ann/walk.html#frame=0&amp;marker=A&amp;doubt=1"' in page and "may be B or A: fits its place" in page


@needs_browser
def test_a_browser_shows_a_page_of_nothing(tmp_path):
    write_run_page(tmp_path, [])
    page = shown(tmp_path / PAGE_NAME, tmp_path / "profile")
    assert "FAILED" not in page and ">None<" in page
