"""What people see of a run."""

import sys
from io import StringIO
from pathlib import Path

from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.outcomes import FAILED, LABELLED, PARTLY, Outcome
from dshpm_jax._archive.progress import STATUS_SECONDS, Progress


def test_lines_of_status(tmp_path, capsys):
    now = [0.0]
    jobs = [Job(tmp_path / f"{k}.c3d", Path(f"{k}.c3d")) for k in range(4)]
    for job in jobs:
        job.source.write_bytes(b"1234")
    progress = Progress(jobs, clock=lambda: now[0])
    found = {"frames": 300, "completeness": 0.9, "trajectories": 40, "labelled_trajectories": 34}
    for job, outcome in zip(jobs, (LABELLED, PARTLY, FAILED, LABELLED), strict=True):
        now[0] += 0.6 * STATUS_SECONDS
        progress.take(Outcome(job, outcome, figures={} if outcome == FAILED else found, was_there=job is jobs[3]))
    progress.end(tmp_path)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{jobs[0].source}: labelled, 90.0% of the markers found, 34 of 40 trajectories"
    assert lines[1].startswith("1 of 4 files, 8 frames/s, 1 labelled, 0 partly labelled, 0 failed, expected end ")
    assert lines[3].startswith("3 of 4 files, 6 frames/s, 1 labelled, 1 partly labelled, 1 failed, expected end ")
    assert lines[4] == f"{jobs[3].source}: up to date"
    assert lines[5] == f"2 of 4 recordings labelled, 1 partly labelled, 1 failed, results in {tmp_path}"
    assert not progress.all_labelled


def test_a_bar_on_a_terminal(tmp_path, monkeypatch):
    terminal = StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    progress = Progress([Job(tmp_path / "walk.c3d", Path("walk.c3d"))])
    progress.take(Outcome(Job(tmp_path / "walk.c3d", Path("walk.c3d")), FAILED, "walk.c3d: it is gone"))
    progress.end(tmp_path)
    assert "1/1 files, 0 labelled, 0 partly labelled, 1 failed" in terminal.getvalue()
    assert "dshpm-jax: walk.c3d: it is gone\n" in terminal.getvalue()
