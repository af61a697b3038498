"""What a person decided is in the result, its sidecar, its page, the summary and the report; gaps with their flag."""

import csv
import json
import subprocess
import sys
from urllib.request import Request, urlopen

import numpy as np
import pytest
from wrong_results import ARMS_EXCHANGED, labelling_as, model, take, write_wrong

import dshpm_jax
from dshpm_jax import Recording, io
from dshpm_jax._corrections import corrections_path, read_corrections
from dshpm_jax._reconstruction import ExpectedErrors, reconstruct
from dshpm_jax._review.candidates import Evidence, candidates
from dshpm_jax._review.edits import Span
from dshpm_jax._review.gaps import Gaps
from dshpm_jax._review.naming import add_names, sources_of, take_names
from dshpm_jax._review.places import place_of, places_in
from dshpm_jax._review.trial import CannotOpen, open_trial
from dshpm_jax._review.waiting import queue
from dshpm_jax._review.writing import Writer, write_back, write_folder
from dshpm_jax._settings import Settings


@pytest.fixture
def toes(tmp_path):
    """A folder of results in which the toes are exchanged."""
    return write_wrong(tmp_path, {"LTOE": "RTOE", "RTOE": "LTOE"})


def opened(out):
    (place,) = places_in(out).values()
    return open_trial(place)


def test_what_is_corrected_is_in_all_files(toes):
    before = (toes / "walk.c3d").read_bytes()
    trial = opened(toes)
    assert [row["count"] for row in queue([trial.place])] == [2]
    trial.session.solver = None
    trial.session.propose({"kind": "exchange", "one": "LTOE", "other": "RTOE", "first": 0, "last": 120})
    trial.session.propose({"kind": "cut", "track": 3, "frame": 50})
    write_back(trial)
    write_folder(toes)
    trial.close()
    found, names = io.read(toes / "walk.c3d"), take()[1]
    recording = io.read(toes.parent / "captures" / "walk.c3d")
    for label in ("LTOE", "RTOE"):
        np.testing.assert_array_equal(found[label], recording.points[:, names.index(label)])
    assert (toes / "walk.c3d").read_bytes() != before
    sidecar = io.read_sidecar(toes / "walk.labels.json")
    corrections = read_corrections(corrections_path(toes / "walk.c3d"))
    assert sidecar is not None and corrections is not None
    assert sidecar["corrections"] == [one.id for one in corrections.standing]
    assert [row["count"] for row in queue(places_in(toes).values())] == [0]
    assert "LTOE" in (toes / "walk.html").read_text() and "walk.c3d" in (toes / "report.html").read_text()
    rows = list(csv.DictReader((toes / "summary.csv").read_text().splitlines()))
    assert [row["outcome"] for row in rows] == ["labelled"]
    again = opened(toes)
    assert len(again.session.labelling.trajectories) == len(trial.session.labelling.trajectories)
    again.session.undo()
    again.session.undo()
    write_back(again)
    again.close()
    assert (toes / "walk.c3d").read_bytes() == before


def test_two_cannot_correct_the_same_trial(toes):
    trial = opened(toes)
    with pytest.raises(CannotOpen, match="walk.c3d: somebody else is correcting it"):
        opened(toes)
    trial.close()
    opened(toes).close()
    assert not list(toes.glob(".*.lock"))


@pytest.mark.parametrize("what", ["gone", "changed", "sidecar", "corrections"])
def test_what_cannot_be_opened_says_why(toes, what):
    source, sidecar = toes.parent / "captures" / "walk.c3d", toes / "walk.labels.json"
    texts = {"gone": "not there any more", "changed": "has changed", "sidecar": "is damaged", "corrections": "line 1"}
    if what == "gone":
        source.unlink()
    elif what == "changed":
        source.write_bytes(source.read_bytes() + b"\0")
    elif what == "sidecar":
        sidecar.write_text("{")
    else:
        corrections_path(toes / "walk.c3d").write_text("{}\n")
    with pytest.raises(CannotOpen, match=texts[what]):
        opened(toes)


def test_without_its_model_labels_alone_change(toes):
    (toes.parent / "captures" / "model.json").unlink()
    trial = opened(toes)
    assert trial.session.solver is None and not trial.knows_body
    trial.session.propose({"kind": "exchange", "one": "LTOE", "other": "RTOE", "first": 0, "last": 120})
    write_back(trial)
    trial.close()
    np.testing.assert_array_equal(io.read(toes / "walk.c3d")["LTOE"], take()[0].points[:, take()[1].index("LTOE")])


def test_a_result_that_somebody_changed_stays_and_the_corrections_too(toes):
    trial, told = opened(toes), []
    (toes / "walk.c3d").write_bytes(b"mine")
    writer = Writer(told.append)
    trial.session.kept = lambda: writer.touch(trial)
    trial.session.propose({"kind": "cut", "track": 3, "frame": 50})
    writer.end()
    trial.close()
    assert (toes / "walk.c3d").read_bytes() == b"mine"
    assert any("your corrections are kept" in line for line in told)
    assert len(read_corrections(corrections_path(toes / "walk.c3d")).lines) == 1  # pyright: ignore


def test_a_limb_is_among_the_likely_labels(tmp_path):
    trial = opened(write_wrong(tmp_path, ARMS_EXCHANGED))
    labelling = trial.session.labelling
    track = int(np.flatnonzero(labelling.identity == model().markers.index("RWRA"))[0])
    found = candidates(labelling, track, Evidence(labelling, Settings()))
    assert [one.label for one in found][:2] == ["RWRA", "LWRA"] and found[0].probability == 0.8
    assert sum(one.probability for one in found) == pytest.approx(1, abs=0.01)
    by_name = candidates(labelling, track, None)
    assert by_name[0].label == "RWRA" and by_name[1].label is None
    trial.close()


def gappy(tmp_path):
    """A result whose LKNE is missing for a while."""
    recording, names = take()
    points = recording.points.copy()
    points[40:52, names.index("LKNE")] = np.nan
    source = tmp_path / "gappy.c3d"
    io.write_c3d(Recording(points, ("",) * len(names), recording.rate), source)
    return labelling_as(io.read(source), names), recording.points[40:52, names.index("LKNE")]


def test_a_gap_is_filled_when_it_is_accepted_and_marked_as_computed(tmp_path):
    labelling, truth = gappy(tmp_path)
    gaps, knee = Gaps(labelling), model().markers.index("LKNE")
    assert (knee, Span(40, 52)) in gaps.places
    listed = gaps.listed([("LKNE", Span(40, 52))], model().markers, [0, 1, 2])
    (one,) = [gap for gap in listed if gap["marker"] == knee]
    assert one["accepted"] and len(one["path"]) == 12
    io.write_labelled(labelling, tmp_path / "out.c3d")
    before = io.read(tmp_path / "out.c3d")
    gaps.fill(labelling, [("LKNE", Span(40, 52)), ("C7", Span(3, 5))], tmp_path / "out.c3d")
    after = io.read(tmp_path / "out.c3d")
    assert after.present.sum() - before.present.sum() == 12
    assert np.linalg.norm(after["LKNE"][40:52] - truth, axis=1).mean() < 15
    ezc3d = pytest.importorskip("ezc3d")
    residuals = ezc3d.c3d(str(tmp_path / "out.c3d"))["data"]["meta_points"]["residuals"][0, knee]
    assert (residuals[40:52] == 0).all() and (residuals[:40] > 0).all()


def test_expected_errors_are_those_of_gaps_that_are_opened(tmp_path):
    labelling, truth = gappy(tmp_path)
    motion = reconstruct(labelling)
    found = ExpectedErrors(motion).of(model().markers.index("LKNE"), 40, 52)
    real = np.sqrt(((motion.filled().recording["LKNE"][40:52] - truth) ** 2).sum(1).mean())
    assert found.body is not None and found.spline is not None
    assert real / 4 < found.body < 4 * real and found.spline > found.body
    assert ExpectedErrors(motion).of(0, 0, 119) == (None, None)


def test_names_for_a_recording_that_nobody_labelled(tmp_path):
    source = write_wrong(tmp_path, {}).parent / "captures" / "walk.c3d"
    out = tmp_path / "named"
    out.mkdir()
    from dshpm_jax._archive import Job

    place = place_of(out, Job(source, source.relative_to(source.parent), page=True))
    trial = open_trial(place)
    assert trial.session.labelling.model.markers == ()
    add_names(trial, ["ONE", "TWO"])
    with pytest.raises(ValueError, match="'\\*7' is no name"):
        add_names(trial, ["*7"])
    trial.session.propose({"kind": "assign", "track": 4, "first": 0, "last": 120, "label": "TWO"})
    sources = {source.text: source for source in sources_of([place])}
    assert "captures/model.json" in sources and "plug-in-gait" in sources
    with pytest.raises(ValueError, match="TWO is a label here"):
        take_names(trial, sources["captures/model.json"])
    write_back(trial)
    trial.close()
    assert io.read(out / "walk.c3d").labels[:2] == ("ONE", "TWO")
    again = opened(out)
    assert again.session.labelling.model.markers == ("ONE", "TWO")
    again.session.undo()
    take_names(again, sources["captures/model.json"])
    assert again.knows_body and again.session.solver is not None
    write_back(again)
    again.close()
    last = opened(out)
    assert last.knows_body and last.session.labelling.model.markers == model().markers
    with pytest.raises(ValueError, match="those of the model"):
        add_names(last, ["THREE"])
    last.close()


def test_a_notebook_has_the_page_and_the_corrections():
    pytest.importorskip("uvicorn", reason="the extra 'review' is not installed")
    recording, names = take()
    labelling = labelling_as(recording, names)
    review = dshpm_jax.review(labelling, name="mine")
    try:
        assert review.address in review._repr_html_() and "0 corrections" in repr(review)
        token = review.address.rstrip("/").rsplit("/", 1)[1]
        host = review.address.split("/")[2]
        headers = {"X-Review-Token": token, "Origin": f"http://{host}"}

        def ask(path, body=None):
            sent = None if body is None else json.dumps(body).encode()
            with urlopen(Request(f"{review.address}api/{path}", sent, headers)) as answer:
                return json.load(answer)

        (trial,) = ask("queue")["trials"]
        shown = ask(f"trial/{trial['id']}")
        assert not shown["in_file"] and ask("status") == {"saved": True, "trouble": ""}
        ask(f"do/{trial['id']}", {"version": 0, "kind": "cut", "track": 2, "frame": 10})
        ask(f"do/{trial['id']}", {"version": 1, "kind": "confirm", "track": 2})
        (known,) = review.corrections
        assert (known.first, known.last) == (0, 10)
        assert len(review.labelling.trajectories) == len(labelling.trajectories) + 1
    finally:
        review.close()


def test_a_recording_is_named_from_nothing_in_a_notebook():
    pytest.importorskip("uvicorn", reason="the extra 'review' is not installed")
    recording = take()[0].frames(0, 4)
    with pytest.raises(ValueError, match="has its own model and names"):
        dshpm_jax.review(labelling_as(*take()), names=["A"])
    review = dshpm_jax.review(recording, names=["ONE", "TWO"])
    assert review.labelling.model.markers == ("ONE", "TWO") and review.corrections == ()
    review.close()


def test_without_the_extra_a_line_says_what_to_install(toes):
    code = (
        "import sys; sys.modules['uvicorn'] = None\n"
        f"from dshpm_jax.__main__ import main; sys.exit(main(['review', {str(toes)!r}, '--no-open']))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert found.returncode == 2
    assert found.stderr.strip().endswith(
        "the page needs uvicorn, which is not installed; pip install 'dshpm-jax[review]'"
    )


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["nothing"], "nothing: holds no manifest.jsonl; give a folder that 'label' wrote, or -o"),
        (["nothing", "-o", "out"], "there is no such file or folder"),
    ],
)
def test_wrong_usage(tmp_path, monkeypatch, capsys, arguments, why):
    from dshpm_jax.__main__ import main

    monkeypatch.chdir(tmp_path)
    assert main(["review", *arguments]) == 2
    assert why in capsys.readouterr().err


def test_a_confirmed_trial_is_no_longer_in_doubt(toes):
    trial = opened(toes)
    trial.session.confirm_all()
    write_back(trial)
    trial.close()
    (row,) = queue(places_in(toes).values())
    assert row["confirmed"] and row["stake"] == row["count"] == 0
    assert "confirmed" in (toes / "report.html").read_text() or write_folder(toes) is None
    assert "confirmed" in (toes / "report.html").read_text()


def test_labels_of_another_program_are_adopted(toes, monkeypatch, capsys):
    from dshpm_jax.__main__ import main
    from dshpm_jax._review.serving import Server

    pytest.importorskip("uvicorn", reason="the extra 'review' is not installed")
    names = take()[1]
    (toes / "walk.c3d").unlink()
    io.write_labelled(labelling_as(io.read(toes.parent / "captures" / "walk.c3d"), names), toes / "walk.c3d")
    monkeypatch.setattr(Server, "run", Server._end)
    assert main(["review", str(toes), "--adopt", "--no-open"]) == 0
    assert "2 changed labels taken over" in capsys.readouterr().out
    trial = opened(toes)
    write_back(trial)
    trial.close()
    np.testing.assert_array_equal(io.read(toes / "walk.c3d")["LTOE"], take()[0].points[:, names.index("LTOE")])
