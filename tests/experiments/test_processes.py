"""Processes that run trials: that they end with the one that started them, however it ends."""

import os
import signal
import subprocess
import sys
import time

import pytest

RUN = """
from dshpm_jax._experiments.processes import Batch, run_apart
from dshpm_jax._experiments.trials import Point
import waiting

if __name__ == "__main__":
    next(run_apart(waiting.plan, 0, [Batch(Point(1, "", 0.0, "full"), range(1))], 1))
"""

WAITING = """
import os, time

def plan(asked):
    with open("worker", "w") as file:
        file.write(str(os.getpid()))
    time.sleep(600)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills processes as POSIX systems do")
def test_workers_do_not_outlive_a_process_that_was_killed(tmp_path):
    (tmp_path / "run.py").write_text(RUN)
    (tmp_path / "waiting.py").write_text(WAITING)
    started = subprocess.Popen([sys.executable, "run.py"], cwd=tmp_path)
    worker = int(_once(lambda: (tmp_path / "worker").read_text()))
    started.kill()
    started.wait()
    try:
        _once(lambda: "gone" if _is_gone(worker) else "")
    finally:
        if not _is_gone(worker):
            os.kill(worker, signal.SIGKILL)


def _once(asked) -> str:
    """What `asked` says as soon as it says something."""
    for _ in range(600):
        try:
            if said := asked():
                return said
        except OSError:
            pass
        time.sleep(0.1)
    pytest.fail("a minute has passed")


def _is_gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    try:  # one that has ended stays until somebody asks how
        with open(f"/proc/{process}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return False
