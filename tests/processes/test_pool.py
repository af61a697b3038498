"""The pool: every call has its answer, and a process that dies costs no other call."""

import os
import time

import calls
import pytest

from dshpm_jax._messages import UsageError
from dshpm_jax._processes import ProcessPool, WorkerDied, machine_memory

MEMORY = 400 << 20  # bytes


@pytest.fixture(scope="module")
def pool():
    with ProcessPool(2, MEMORY) as found:
        yield found


def test_answers_and_errors(pool):
    futures = [pool.submit(calls.double, k) for k in range(20)]
    assert [future.result() for future in futures] == [2 * k for k in range(20)]
    with pytest.raises(ValueError, match="not today"):
        pool.submit(calls.refuse, "not today").result()


def test_what_a_call_tells_is_there_before_its_answer(pool):
    told = []
    assert pool.submit_telling(told.append, calls.count, 3).result() == 3
    assert told == [0, 1, 2]
    with pytest.raises(WorkerDied):
        pool.submit_telling(told.append, calls.tell_and_die).result()
    assert told[3:] == ["so far"]


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="the system cannot pin processes")
def test_processes_share_the_cores(pool):
    have = calls.cores()
    assert pool.submit(calls.cores).result() in (max(1, have // 2), max(1, -(-have // 2)))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills processes as POSIX systems do")
@pytest.mark.parametrize("end", [calls.die, calls.eat_memory])
def test_a_death_costs_its_own_call_only(pool, end):
    dying = pool.submit(end)
    futures = [pool.submit(calls.double, k) for k in range(4)]
    with pytest.raises(WorkerDied):
        dying.result()
    assert [future.result() for future in futures] == [0, 2, 4, 6]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills processes as POSIX systems do")
def test_an_idle_process_that_died_is_started_again():
    with ProcessPool(1) as pool:
        before = pool.submit(calls.process).result()
        os.kill(before, 9)
        time.sleep(0.1)
        assert pool.submit(calls.process).result() != before


@pytest.mark.skipif(not hasattr(os, "fork"), reason="sends signals as POSIX systems do")
def test_ctrl_c_is_for_the_process_that_the_user_started(pool):
    assert pool.submit(calls.interrupt_all).result() == "still here"


def test_processes_that_cannot_start_are_told(monkeypatch):
    monkeypatch.setattr("dshpm_jax._processes.pool.MOST_FAILED_STARTS", 1)
    pool = ProcessPool(1, set_up=calls.die)
    with pytest.raises(UsageError, match="no worker process starts"):
        pool.submit(calls.double, 1).result()
    pool.shutdown()


def test_a_pool_that_is_given_up_ends_at_once():
    pool = ProcessPool(1)
    running, waiting = pool.submit(calls.sleep), pool.submit(calls.sleep)
    pool.submit(calls.sleep)
    while not running.running():
        time.sleep(0.01)
    start = time.monotonic()
    pool.shutdown(cancel_futures=True)
    assert time.monotonic() - start < 30 and waiting.cancelled()
    with pytest.raises(WorkerDied):
        running.result()
    with pytest.raises(RuntimeError, match="shut down"):
        pool.submit(calls.sleep)


def test_the_machine_has_memory():
    found = machine_memory()
    assert found is None or found > 100 << 20
