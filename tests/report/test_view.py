"""The page of a recording holds its points, labels, gaps and confidences, and a browser plays it."""

import base64
import html
from dataclasses import replace

import numpy as np
import pytest
from browser import assert_self_contained, data_of, needs_browser, shown
from hypothesis import given, settings
from hypothesis import strategies as st
from making import make_labelling, make_model, make_recording

import dshpm_jax
from dshpm_jax import Labelling, Reason, Recording, io, view
from dshpm_jax.__main__ import main
from dshpm_jax.report._doubts import CAUSES
from dshpm_jax.report._film import make_film
from dshpm_jax.report._player import MISSING
from dshpm_jax.synthesis import person

EVIL = "</script><img src=x onerror=alert(1)>&'\""
MARKERS = ["LASI", "RASI", "SACR"]


def points_in(data: dict) -> np.ndarray:
    """The points that a page shows (mm), the camera's path without."""
    steps = np.frombuffer(base64.b64decode(data["points"]), "<i2").reshape(data["frames"], data["columns"], 3)
    points = steps * data["step"] + data["centre"]
    return np.where(steps == MISSING, np.nan, points)[:, :-1]


def test_points_labels_and_gaps_are_there():
    recording = make_recording(40)
    data = data_of(dshpm_jax.view(recording).html)
    assert data["names"] == MARKERS and data["rate"] == 100 and data["frames"] == 40 and data["spans"] == []
    points = points_in(data)
    assert points.shape == (40, 4, 3)
    up = next(k for k in range(3) if np.allclose(np.roll(recording.points, -k, -1)[:, 0], points[:, 0], atol=0.1))
    np.testing.assert_allclose(points, np.roll(recording.points, -up, -1), atol=data["step"])


@settings(max_examples=25)
@given(st.integers(0, 1000), st.floats(0.01, 1e6), st.sampled_from([1, 2, 30]))
def test_steps_are_as_fine_as_they_say(seed, size, frames):
    rng = np.random.default_rng(seed)
    points = rng.normal(0, size, (frames, 5, 3))
    points[rng.random((frames, 5)) < 0.3] = np.nan
    points[0, 0] = 0.0
    data = data_of(dshpm_jax.view(Recording(points, tuple("ABCDE"), 50.0)).html)
    assert 0.1 <= data["step"] <= 1.0
    found = points_in(data)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(points))
    centre, reach = np.array(data["centre"]), 32767 * data["step"]  # a point further off is shown there
    errors = [np.abs(np.clip(np.roll(points, -k, -1), centre - reach, centre + reach) - found) for k in range(3)]
    assert min(np.nanmax(error) for error in errors) <= data["step"] / 2 * (1 + 1e-6)


def test_the_axis_that_points_up_comes_last():
    points = person(34, "walking", 60).recording.points
    for k in range(3):
        recording = Recording(np.roll(points, k, -1), tuple(f"m{i}" for i in range(34)), 60.0)
        found = points_in(data_of(dshpm_jax.view(recording).html))
        assert np.nanmax(np.abs(found - points)) < 0.2


def test_a_labelling_brings_confidences_and_segments():
    recording = make_recording(40)
    labelling = make_labelling(recording, MARKERS)
    data = data_of(dshpm_jax.view(labelling).html)
    assert [(part["name"], part["columns"]) for part in data["parts"]] == [("body", [0, 1, 2])]
    assert len(data["links"]) == 2 and {link[2] for link in data["links"]} == {0}
    covered = np.zeros((40, 4), int)
    for column, first, last, confidence, reason, doubtful in data["spans"]:
        assert confidence == 0.875
        assert doubtful == (column < 3)
        assert data["reasons"][reason] in CAUSES if column < 3 else "no marker" in data["reasons"][reason]
        covered[first : last + 1, column] += 1
    np.testing.assert_array_equal(covered, recording.present)


def test_a_file_and_its_sidecar_say_the_same_as_the_labelling(tmp_path):
    labelling = make_labelling(make_recording(40), MARKERS)
    io.write_labelled(labelling, tmp_path / "walk.c3d")
    io.write_sidecar(labelling, tmp_path / "walk.labels.json")
    from_file = data_of(dshpm_jax.view(tmp_path / "walk.c3d").html)
    assert len(from_file["doubts"]) == len([span for span in from_file["spans"] if span[0] < 3])
    assert from_file | {"name": "recording"} == data_of(dshpm_jax.view(labelling).html)


def test_unlabelled_points_of_raw_recordings_keep_their_reasons():
    recording = Recording(np.arange(36.0).reshape(6, 2, 3), ("", ""), 100.0, columns=(3, 7))
    links = np.tile([0, 1], (6, 1))
    links[2], links[5] = [1, 0], -1
    labelling = make_labelling(recording, ["A"], links, names=["A", "*"])
    film = make_film(labelling.to_recording(), io.sidecar(labelling))
    assert [(s.column, s.first, s.last) for s in film.spans if s.column == 0] == [(0, 0, 5)]
    assert sorted((s.first, s.last) for s in film.spans if s.column > 0) == [(0, 2), (3, 5)]


def test_segments_of_a_model():
    data = data_of(dshpm_jax.view(make_recording(40), make_model(["RASI", "SACR", "NOSE"])).html)
    assert [part["columns"] for part in data["parts"]] == [[1, 2]] and data["links"] == [[1, 2, 0]]


def test_rigid_neighbours_are_linked_where_nothing_is_known():
    rng = np.random.default_rng(0)
    bodies = rng.normal(0, 50, (2, 4, 3)) + np.array([[0.0, 0, 0], [300, 0, 0]])[:, None]
    sway = rng.normal(0, 200, (80, 2, 1, 3)).cumsum(0)
    recording = Recording((bodies + sway).reshape(80, 8, 3), tuple("ABCDEFGH"), 100.0)
    links = data_of(dshpm_jax.view(recording).html)["links"]
    assert len(links) == 6 and all((i < 4) == (j < 4) and part == -1 for i, j, part in links)


def test_nothing_but_unlabelled_points():
    recording = Recording(make_recording(20).points, ("", "*2", "", ""), 100.0)
    data = data_of(dshpm_jax.view(recording).html)
    assert data["names"] == [] and data["columns"] == 5 and data["links"] == []


def test_no_points():
    with pytest.raises(ValueError, match="nothing to show"):
        dshpm_jax.view(Recording(np.full((5, 3, 3), np.nan), tuple(MARKERS), 100.0))


def test_a_sidecar_of_another_recording(tmp_path):
    labelling = make_labelling(make_recording(40), MARKERS)
    io.write_labelled(labelling, tmp_path / "walk.c3d")
    for other in (make_labelling(make_recording(41), MARKERS), make_labelling(make_recording(40, ["A"]), ["A"])):
        io.write_sidecar(other, tmp_path / "walk.labels.json")
        with pytest.raises(io.ReadError, match="walk.c3d: the sidecar beside it is about another recording; move"):
            dshpm_jax.view(tmp_path / "walk.c3d")


def test_names_may_hold_anything():
    page = dshpm_jax.view(Recording(make_recording(20).points, (EVIL, "B", "C", "*"), 100.0), name=EVIL)
    assert_self_contained(page.html)
    assert data_of(page.html)["names"][0] == EVIL
    frame = page._repr_html_()
    assert frame.count("<") == 2 and html.unescape(frame.split('srcdoc="')[1].split('"')[0]) == page.html
    assert len(repr(page)) < 100


def test_a_page_gives_way_to_a_page_and_nothing_else(tmp_path):
    page = dshpm_jax.view(make_recording(20))
    page.save(tmp_path / "a.html")
    page.save(tmp_path / "a.html")
    (tmp_path / "b.html").write_text("my own")
    with pytest.raises(io.WriteError, match="no page of ours"):
        page.save(tmp_path / "b.html")
    assert (tmp_path / "b.html").read_text() == "my own" and len(list(tmp_path.iterdir())) == 2


def command(capsys, *arguments):
    status = main(list(arguments))
    out, err = capsys.readouterr()
    return status, out, err


def test_the_command(folder, capsys):
    assert command(capsys, "view", "walk.c3d") == (0, "walk.html\n", "")
    assert data_of((folder / "walk.html").read_text())["parts"] == []
    assert command(capsys, "view", "walk.c3d", "-o", "page.html", "--model", "model.json")[0] == 0
    assert data_of((folder / "page.html").read_text())["parts"][0]["name"] == "body"


def test_the_command_with_what_it_cannot_do(folder, capsys):
    (folder / "bad.c3d").write_bytes(b"")
    status, out, err = command(capsys, "view", "bad.c3d", "walk.c3d")
    assert status == 1 and out == "walk.html\n" and "bad.c3d: the file is empty" in err and err.count("\n") == 1
    (folder / "empty").mkdir()
    status, _, err = command(capsys, "view", "empty")
    assert status == 1 and "holds no manifest.jsonl" in err and not list((folder / "empty").iterdir())
    for wrong in (
        ["bad.c3d", "walk.c3d", "-o", "page.html"],
        [".", "-o", "page.html"],
        ["walk.c3d", "-o", "model.json"],
        ["walk.c3d", "-o", "nowhere/page.html"],
        ["walk.c3d", "--model", "walk.c3d"],
        ["walk.c3d", "--model", "nowhere.json"],
    ):
        status, _, err = command(capsys, "view", *wrong)
        assert status == 2 and err.count("\n") == 1


def test_a_folder_of_results(folder, capsys):
    out = folder / "out"
    (out / "ann").mkdir(parents=True)
    labelling = make_labelling(make_recording(40), MARKERS)
    io.write_labelled(labelling, out / "ann" / "walk.c3d")
    io.write_sidecar(labelling, out / "ann" / "walk.labels.json")
    (out / "manifest.jsonl").write_text(
        '{"input": "/a/run.c3d", "output": "ann/run.c3d", "outcome": "failed", "message": "no", "finished": "1"}\n'
        '{"input": "/a/walk.c3d", "output": "ann/walk.c3d", "outcome": "labelled", "finished": "1"}\n'
    )
    assert command(capsys, "view", "out") == (0, "out/ann/walk.html\n", "")
    trials = data_of((out / "report.html").read_text())["trials"]
    assert [(trial[0], trial[-1].get("page")) for trial in trials] == [("ann/run.c3d", None), ("ann/walk.c3d", 1)]


def doubting(recording: Recording) -> Labelling:
    """A labelling whose first trajectory may be another, whose model fits badly, and which withholds a label."""
    found = make_labelling(recording, MARKERS)
    found.confidence[:] = np.where(np.arange(len(found.confidence)) == 0, 0.875, 0.99)
    (withheld, *_) = np.flatnonzero(found.identity == -1)
    reason = tuple(Reason.AMBIGUOUS if j == withheld else reason for j, reason in enumerate(found.reason))
    could_be = np.full((len(reason), 2), -1)
    could_be[0], could_be[withheld] = [int(found.identity[0] == 1) + 1, -1], [2, 1]
    return replace(found, reason=reason, could_be=could_be, stats={"model_fit": 0.5})


def test_doubts_are_one_a_trajectory_and_lead_to_its_points():
    recording = Recording(make_recording(40).points, (*MARKERS, "*4"), 100.0)
    labelling = doubting(recording)
    data = data_of(dshpm_jax.view(labelling).html)
    (known, withheld) = [[*span[:3], data["reasons"][span[4]]] for span in sorted(data["doubts"])]
    first = labelling.trajectories.stop[0] - 1
    assert known == [labelling.identity[0], 0, first, f"may be {known[3][7:11]}: the model fits this trial badly"]
    assert withheld[3] == "no label, may be SACR or RASI: two labels fit almost equally well"
    assert np.isfinite(points_in(data)[withheld[1] : withheld[2] + 1, withheld[0]]).all()
    assert "50% of the usual evidence" in data["troubles"][0]


def test_people_far_apart_stand_upright():
    points = person(34, "walking", 60).recording.points
    labels = tuple(f"{name}:{k}" for name in ("ann", "ben") for k in range(34))
    recording = Recording(np.concatenate([points, points + [4000.0, 0, 0]], 1), labels, 60.0)
    found = points_in(data_of(dshpm_jax.view(recording).html))
    assert np.nanmax(np.abs(found - recording.points)) < 0.2


@needs_browser
def test_a_browser_leads_from_doubt_to_doubt(tmp_path):
    recording = Recording(make_recording(40).points, (*MARKERS, "*4"), 100.0)
    dshpm_jax.view(doubting(recording)).save(tmp_path / "walk.html")
    page = shown(tmp_path / "walk.html", tmp_path / "profile")
    assert "FAILED" not in page and ">2 labels in doubt<" in page and "50% of the usual evidence" in page
    keys = "".join(f"dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}'}}));" for key in "fstrlunn")
    (tmp_path / "walk.html").write_text(
        (tmp_path / "walk.html").read_text().replace("</body>", f"<script>{keys}</script></body>")
    )
    page = shown(tmp_path / "walk.html", tmp_path / "profile")
    assert "FAILED" not in page and ">2 of 2: no label, may be SACR or RASI" in page
    page = shown(tmp_path / "walk.html", tmp_path / "profile", "#frame=0&doubt=1&view=top")
    assert "FAILED" not in page


@needs_browser
def test_a_browser_sees_all_of_the_figure(tmp_path):
    made = person(34, "walking", 120).recording
    page = dshpm_jax.view(made).html
    probe = """<script>
    const {width, height} = canvas.getBoundingClientRect();
    let out = 0;
    for (const where of ["start", "front", "side", "top"]) {
      lookFrom(where);
      for (let t = 0; t < frames; t += 10) {
        view.frame = t;
        element("named").checked = true;
        draw();
        for (const {x, y} of dots) out += x < 0 || y < 0 || x > width || y > height;
      }
    }
    document.title = `${out} out of view`;
    </script>"""
    (tmp_path / "walk.html").write_text(page.replace("</body>", probe + "</body>"))
    found = shown(tmp_path / "walk.html", tmp_path / "profile")
    assert "FAILED" not in found and "<title>0 out of view</title>" in found


@needs_browser
def test_names_in_a_browser_do_not_overlap(tmp_path):
    made = person(49, "walking", 30).recording
    page = dshpm_jax.view(made).html
    probe = """<script>
    const boxes = [], plain = drawName;
    element("named").checked = true;
    drawName = (name, box, ...rest) => { boxes.push(box); plain(name, box, ...rest); };
    draw();
    const pairs = boxes.flatMap((a, k) => boxes.slice(k + 1).map(b => apart(a, b)));
    document.title = `${boxes.length > 30} ${pairs.every(Boolean)}`;
    </script>"""
    (tmp_path / "walk.html").write_text(page.replace("</body>", probe + "</body>"))
    assert "<title>true true</title>" in shown(tmp_path / "walk.html", tmp_path / "profile")


@needs_browser
def test_a_browser_plays_it(tmp_path):
    recording = Recording(make_recording(5000).points, (EVIL, "B", "C", "*"), 100.0)
    dshpm_jax.view(make_labelling(recording, [EVIL, "B", "C"])).save(tmp_path / "walk.html")
    still = shown(tmp_path / "walk.html", tmp_path / "profile", "#frame=100")
    assert (
        "FAILED" not in still and ">frame 100 of 5000" in still and "3 labels, 5,000 frames, 50.0 s at 100 Hz" in still
    )
    playing = shown(tmp_path / "walk.html", tmp_path / "profile", "#frame=100&play")
    assert "FAILED" not in playing and ">Pause<" in playing and ">frame 100 of" not in playing


def test_a_frame_to_be_named():
    recording = Recording(make_recording(20).points, ("", "*2", "", ""), 100.0)
    frame = int(recording.present.sum(1).argmin())
    seen = np.flatnonzero(recording.present[frame]).tolist()
    data = data_of(dshpm_jax.view_frame(recording, frame, {seen[-1]: EVIL}, {"part": [EVIL]}).html)
    assert data["numbers"] == seen and data["names"] == [*map(str, seen[:-1]), EVIL]
    assert data["parts"][0]["columns"] == [len(seen) - 1] and data["frames"] == 1
    with pytest.raises(ValueError, match="has frames 0 to 19"):
        dshpm_jax.view_frame(recording, 20)
    with pytest.raises(ValueError, match="several points are called A"):
        dshpm_jax.view_frame(recording, frame, {seen[0]: "A", seen[1]: "A"})


@needs_browser
def test_a_browser_turns_names_into_python(tmp_path):
    page = dshpm_jax.view_frame(make_recording(1), 0, {0: "LASI", 3: 'a "b"'}, {"pelvis": ["LASI", 'a "b"']})
    told = "<script>document.title = answer.value.replaceAll('\\n', ' ')</script>"
    (tmp_path / "still.html").write_text(page.html.replace("</body>", told + "</body>"))
    found = shown(tmp_path / "still.html", tmp_path / "profile")
    title = html.unescape(found.split("<title>")[1].split("</title>")[0])
    assert "FAILED" not in found
    assert (
        " ".join(title.split()) == 'names = {0: "LASI", 3: "a \\"b\\""} segments = { "pelvis": ["LASI", "a \\"b\\""], }'
    )


def test_notes_of_the_reader_are_shown(tmp_path):
    recording = replace(make_recording(), notes=("2 points keep their coordinates",))
    assert data_of(view(recording).html)["notes"] == ["2 points keep their coordinates"]
    labelling = make_labelling(recording, ["LASI"])
    io.write_labelled(labelling, tmp_path / "walk.c3d")
    io.write_sidecar(labelling, tmp_path / "walk.labels.json")
    for page in (view(labelling), view(tmp_path / "walk.c3d")):
        assert data_of(page.html)["notes"] == ["2 points keep their coordinates"]
