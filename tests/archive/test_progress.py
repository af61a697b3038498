"""What people see of a run."""

import sys
from io import StringIO
from pathlib import Path
from threading import Event

import pytest

from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.outcomes import Outcome
from dshpm_jax._archive.progress import STATUS_SECONDS, Progress, every
from dshpm_jax._outcomes import DOUBTFUL, FAILED, LABELLED, PARTLY, PASSED

FOUND = {"frames": 300, "completeness": 0.9, "never_seen": [], "trajectories": 40, "labelled_trajectories": 34}


def outcome_of(job, outcome, **more):
    return Outcome(job, outcome, figures={} if outcome == FAILED else FOUND | more)


@pytest.fixture
def jobs(tmp_path):
    found = [Job(tmp_path / f"{k}.c3d", Path(f"{k}.c3d")) for k in range(5)]
    for job in found:
        job.source.write_bytes(b"1234")
    return found


def test_a_line_for_each_outcome_and_one_at_the_end(jobs, tmp_path, capsys):
    progress = Progress(jobs)
    progress.take(outcome_of(jobs[0], LABELLED))
    progress.take(outcome_of(jobs[1], DOUBTFUL, never_seen=[*"ABCDEFGH"], completeness=0.99999))
    progress.take(outcome_of(jobs[2], FAILED))
    progress.take(Outcome(jobs[3], LABELLED, figures=FOUND, was_there=True))
    progress.take(outcome_of(jobs[4], PARTLY, never_seen=["A", "B"], labelled_trajectories=0))
    progress.end(tmp_path, tmp_path / "report.html")
    assert capsys.readouterr().out.splitlines() == [
        f"{jobs[0].source}: labelled, 90.0% of the markers' points, 34 of 40 trajectories",
        f"{jobs[1].source}: doubtful, 99.9% of the markers' points, 34 of 40 trajectories, "
        "never seen: A, B, C, D, E, F and 2 more",
        f"{jobs[3].source}: up to date",
        f"{jobs[4].source}: partly labelled, 90.0% of the markers' points, 0 of 40 trajectories",
        f"2 of 5 recordings labelled, 1 failed, 1 doubtful, 1 partly labelled, results in {tmp_path}",
        f"open {tmp_path / 'report.html'} in a browser to see what needs you",
    ]
    assert not progress.all_labelled


def test_files_without_points_are_no_failure(jobs, tmp_path, capsys):
    progress = Progress(jobs[:2])
    progress.take(outcome_of(jobs[0], LABELLED))
    progress.take(Outcome(jobs[1], PASSED, "1.c3d: it holds no points (passed over)"))
    progress.end(tmp_path)
    assert progress.all_labelled and "1 of 2 recordings labelled, 1 passed over" in capsys.readouterr().out


def test_status_comes_by_the_clock_not_by_outcomes(jobs, capsys):
    now = [0.0]
    progress = Progress(jobs, clock=lambda: now[0])
    progress.notice("compiling, once on this machine")
    progress.notice("compiling, once on this machine")
    for _ in range(3):
        now[0] += 0.5 * STATUS_SECONDS
        progress.tick()
    assert capsys.readouterr().out.splitlines() == [
        "compiling, once on this machine",
        "0 of 5 files, compiling, once on this machine",
    ]
    progress.take(outcome_of(jobs[0], LABELLED))
    progress.notice("reading 3 files")  # which is no line of its own any more
    now[0] += STATUS_SECONDS
    progress.take(outcome_of(jobs[1], PARTLY))
    capsys.readouterr()
    progress.tick()
    progress.tick()
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith("2 of 5 files, 8 frames/s, 1 partly labelled, 1 labelled, expected end ")
    assert line.endswith(", reading 3 files")


def test_a_bar_on_a_terminal(tmp_path, monkeypatch):
    terminal = StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    progress = Progress([Job(tmp_path / "walk.c3d", Path("walk.c3d"))])
    progress.notice("reading 1 file")
    progress.tick()
    assert "0/1 files, reading 1 file" in terminal.getvalue()
    progress.take(Outcome(Job(tmp_path / "walk.c3d", Path("walk.c3d")), FAILED, "walk.c3d: it is gone"))
    progress.end(tmp_path)
    assert "1/1 files, 1 failed" in terminal.getvalue()
    assert "dshpm-jax: walk.c3d: it is gone\n" in terminal.getvalue()


def test_the_clock_ticks_while_something_else_runs_and_stops_with_it():
    ticks, third = [], Event()

    def tick():
        ticks.append(None)
        if len(ticks) == 3:
            third.set()

    with every(0.001, tick):
        assert third.wait(60)
    count = len(ticks)
    assert not Event().wait(0.05) and len(ticks) == count
