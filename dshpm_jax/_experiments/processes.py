"""Trials in several processes, each on cores of its own; what they find does not depend on how many there are."""

import os
from collections.abc import Callable, Hashable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import Any, NamedTuple

from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._experiments.trials import Outcome, Plan, Point, run_trials, warm_up
from dshpm_jax._settings import Method


class Batch(NamedTuple):
    """Trials of one point that are labelled side by side."""

    point: Point
    trials: range


Make = Callable[[Any], Plan]
"""Makes the plan of what was asked for, in every process again: it goes there by its name."""


def run_apart(make: Make, asked: Hashable, batches: Sequence[Batch], workers: int) -> Iterator[list[Outcome]]:
    """The outcomes of `batches` in their order, labelled in `workers` processes."""
    context = get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, _settle_in, (context.Value("i", 0), workers))
    try:
        yield from pool.map(partial(_label, make, asked), batches)
    finally:
        pool.shutdown(cancel_futures=True)


def _settle_in(taken: Any, workers: int) -> None:
    """Takes this process to its cores, where the system can, before anything of jax runs."""
    Thread(target=_end_with_parent, daemon=True).start()
    cache_programs()
    with taken:
        place, taken.value = taken.value, taken.value + 1
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[place % len(cores) :: workers])


def _end_with_parent() -> None:
    """A process that was killed cannot stop those that it started: they would wait for work, with all their memory."""
    if (parent := parent_process()) is not None:
        parent.join()
        os._exit(1)


def _label(make: Make, asked: Hashable, batch: Batch) -> list[Outcome]:
    _warm(make, asked, batch.point.markers, batch.point.method)
    return run_trials(_plan(make, asked), *batch)


@cache
def _plan(make: Make, asked: Hashable) -> Plan:
    return make(asked)


@cache
def _warm(make: Make, asked: Hashable, markers: int, method: Method) -> None:
    """Compiles what trials of so many markers need, once a process."""
    plan = _plan(make, asked)
    warm_up(plan, [next(p for p in plan.points if (p.markers, p.method) == (markers, method))])
