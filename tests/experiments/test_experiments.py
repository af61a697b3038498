"""The experiments as commands: tables of the right shape, figures, the same numbers again, nothing lost."""

import csv
import sys

import numpy as np
import pytest

from dshpm_jax import Labelling, Reason, io
from dshpm_jax.__main__ import main
from dshpm_jax._experiments import corruption, distortion, running, table1, trials
from dshpm_jax._experiments.subjects import synthetic
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH

FRAMES = 60
PNG, PDF = b"\x89PNG", b"%PDF"


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """One density, few levels."""
    monkeypatch.setattr(running, "DENSITIES", (30,))
    monkeypatch.setattr(table1, "PROTOCOLS", (27,))
    monkeypatch.setattr(distortion, "LEVELS", (0.0, 0.1))
    monkeypatch.setattr(corruption, "FRACTIONS", (0.3,))


@pytest.fixture
def labeller(monkeypatch):
    """Stands in for the real one and counts the recordings: it labels every second trajectory, wrong as a rule."""
    seen = []

    def label_many(recordings, models, settings, driver):
        for recording, model in zip(recordings, models, strict=True):
            seen.append(recording)
            tracks = from_columns(recording.points, recording.rate)
            identity = np.where(np.arange(len(tracks)) % 2, np.arange(len(tracks)) % model.num_markers, NO_MATCH)
            reason = (Reason.MATCHED,) * len(tracks)
            yield Labelling(
                recording, model, tracks, identity, np.ones(len(tracks)), reason, {"svd_count": len(tracks)}
            )

    monkeypatch.setattr(trials, "label_many", label_many)
    return seen


def run(out, name, *more):
    return main(["experiment", name, "-o", str(out), "--trials", "2", "--frames", str(FRAMES), *map(str, more)])


def rows(path):
    with path.open(newline="") as lines:
        return list(csv.DictReader(lines))


def numbers(path):
    """The rows of a table without the times, which differ from run to run."""
    return [{k: v for k, v in row.items() if k not in ("seconds", "alone")} for row in rows(path)]


@pytest.mark.parametrize(
    ("name", "trials_of", "points"),
    [
        ("table1", "table1", 3 * 2 * 2),
        ("distortion", "distortion", 3 * 2),
        ("corruption", "corruption", 2 * 3),
        ("complexity", "corruption", 2 * 3),
    ],
)
def test_tables_and_figures(labeller, tmp_path, name, trials_of, points):
    assert run(tmp_path, name) == 0
    table, raw = rows(tmp_path / f"{name}.csv"), rows(tmp_path / f"{trials_of}-trials.csv")
    assert len(table) == points and len(raw) == 2 * points
    assert all(row["trials"] == "2" for row in table)
    assert all(0 <= float(row["rate"]) <= 1 for row in raw)
    assert (tmp_path / f"{name}.png").read_bytes().startswith(PNG)
    assert (tmp_path / f"{name}.pdf").read_bytes().startswith(PDF)


def test_table1_has_the_paper_beside_it(labeller, tmp_path):
    run(tmp_path, "table1")
    for row in rows(tmp_path / "table1.csv"):
        assert float(row["frames"]) == (2 * FRAMES if row["activity"] == "freeform" else FRAMES)
        assert 0.9 < float(row["paper_rate"]) < 1 and int(row["paper_frames_per_second"]) >= 130
        assert float(row["trajectories"]) > int(row["markers"])
    assert {row["breaks"] for row in rows(tmp_path / "table1.csv")} == set(table1.BREAKS.values())


def test_the_same_seed_gives_the_same_numbers(labeller, tmp_path):
    for out in ("a", "b"):
        run(tmp_path / out, "corruption")
    run(tmp_path / "c", "corruption", "--seed", 1)
    first, again, other = (numbers(tmp_path / out / "corruption-trials.csv") for out in "abc")
    assert first == again != other


def test_trials_that_are_there_are_kept(labeller, tmp_path):
    run(tmp_path / "once", "distortion")
    run(tmp_path / "twice", "distortion", "--trials", 1)
    before = rows(tmp_path / "twice" / "distortion-trials.csv")
    run(tmp_path / "twice", "distortion")
    after = rows(tmp_path / "twice" / "distortion-trials.csv")
    assert all(row in after for row in before)
    assert numbers(tmp_path / "once" / "distortion.csv") == numbers(tmp_path / "twice" / "distortion.csv")


def test_complexity_takes_the_trials_of_corruption(labeller, tmp_path):
    run(tmp_path, "corruption")
    labeller.clear()
    run(tmp_path, "complexity")
    assert not labeller
    fits = [float(row["fits"]) for row in rows(tmp_path / "complexity.csv")]
    assert fits == [float(row["trajectories"]) for row in rows(tmp_path / "corruption.csv")]  # as the labeller says


def test_another_setup_in_the_same_folder_is_refused(labeller, tmp_path, capsys):
    run(tmp_path, "distortion")
    before = (tmp_path / "distortion-trials.csv").read_bytes()
    capsys.readouterr()
    assert run(tmp_path, "distortion", "--seed", 1) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert (tmp_path / "distortion-trials.csv").read_bytes() == before


def test_files_that_are_not_ours_stay(labeller, tmp_path, capsys):
    (tmp_path / "distortion-trials.csv").write_text("precious")
    assert run(tmp_path, "distortion") == 2
    assert "another folder" in capsys.readouterr().err
    assert (tmp_path / "distortion-trials.csv").read_text() == "precious"


@pytest.mark.parametrize("kind", ["csv", "png", "pdf"])
def test_results_without_their_trials_stay(labeller, tmp_path, capsys, kind):
    (tmp_path / f"distortion.{kind}").write_text("precious")
    assert run(tmp_path, "distortion") == 2
    assert "is there without its trials, not overwritten" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == [f"distortion.{kind}"]


def test_a_table_of_trials_that_was_cut_off_is_said(labeller, tmp_path, capsys):
    assert run(tmp_path, "distortion") == 0
    table = tmp_path / "distortion-trials.csv"
    table.write_bytes(table.read_bytes()[:-20])
    capsys.readouterr()
    assert run(tmp_path, "distortion") == 2
    assert "is damaged and cannot be gone on with" in capsys.readouterr().err


def test_without_matplotlib_the_tables_are_written(labeller, monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert run(tmp_path, "distortion") == 0
    assert "dshpm-jax[pictures]" in capsys.readouterr().err
    assert (tmp_path / "distortion.csv").exists() and not (tmp_path / "distortion.png").exists()


@pytest.mark.parametrize("name", ["table1", "distortion", "complexity"])
def test_a_recording_of_one_s_own(labeller, tmp_path, name):
    subject = synthetic(34, "running", 100, 0, 1)
    io.write_c3d(subject.recording, tmp_path / "run.c3d")
    io.write_model(subject.model, tmp_path / "model.json")
    given = ("--recording", tmp_path / "run.c3d", "--model", tmp_path / "model.json")
    assert run(tmp_path / "out", name, *given) == 0
    assert {row["markers"] for row in rows(tmp_path / "out" / f"{name}.csv")} == {"34"}
    assert {len(r.points) for r in labeller} <= {FRAMES, trials.STATIC_FRAMES}
    assert run(tmp_path / "out", name) == 2  # a folder holds one setup


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--recording", "walk.c3d"), "--recording and --model go together"),
        (("--recording", "no.c3d", "--model", "no.json"), "no.json"),
        (("--trials", "0"), "at least one trial"),
        (("--workers", "0"), "at least one process"),
        (("--seed", "-1"), "not negative"),
    ],
)
def test_wrong_usage(tmp_path, capsys, arguments, words):
    assert run(tmp_path, "distortion", *arguments) == 2
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1


def test_methods_get_the_same_trials(labeller):
    plan = running._plan(running.ExperimentOrder("corruption", frames=FRAMES, seed=3))
    by_place = {}
    for point in plan.points:
        by_place.setdefault(point[:3], []).append(plan.case(point, 1))
    assert len(by_place) == 3
    for one, other in by_place.values():
        np.testing.assert_array_equal(one.recording.points, other.recording.points)
        np.testing.assert_array_equal(one.truth, other.truth)


@pytest.mark.slow
def test_clean_sequences_are_identified(monkeypatch, tmp_path):
    """The real thing, small: what is not spoilt is identified."""
    monkeypatch.setattr(distortion, "LEVELS", (0.0,))
    monkeypatch.setattr(distortion, "METHODS", ("paper", "full"))
    assert run(tmp_path, "distortion", "--trials", 1) == 0
    assert [float(row["rate"]) for row in rows(tmp_path / "distortion.csv")] == [1.0, 1.0]


@pytest.mark.slow
def test_several_processes_give_the_same_numbers(monkeypatch, tmp_path):
    monkeypatch.setattr(distortion, "LEVELS", (0.0, 0.1))
    monkeypatch.setattr(distortion, "METHODS", ("paper",))
    subject = synthetic(30, "walking", 80, 0, 1)
    io.write_c3d(subject.recording, tmp_path / "walk.c3d")
    io.write_model(subject.model, tmp_path / "model.json")
    given = ("--recording", tmp_path / "walk.c3d", "--model", tmp_path / "model.json")
    for workers in (1, 2):
        assert run(tmp_path / str(workers), "distortion", *given, "--workers", workers) == 0
    one, two = (numbers(tmp_path / workers / "distortion-trials.csv") for workers in "12")
    assert one == two and len(one) == 4
