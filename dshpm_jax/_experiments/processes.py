"""Trials in several processes; what they find does not depend on how many there are."""

from collections.abc import Callable, Hashable, Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._experiments.trials import ExperimentPlan, Point, TrialResult, run_trials, warm_up
from dshpm_jax._messages import UsageError
from dshpm_jax._processes import ProcessPool, WorkerDied
from dshpm_jax._settings import Method


class Batch(NamedTuple):
    """Trials of one point that are labelled side by side."""

    point: Point
    trials: range


Make = Callable[[Any], ExperimentPlan]
"""Makes the plan of what was asked for, in every process again: it goes there by its name."""


def run_apart(make: Make, asked: Hashable, batches: Sequence[Batch], workers: int) -> Iterator[list[TrialResult]]:
    """The results of `batches` in their order, labelled in `workers` processes."""
    pool = ProcessPool(workers, set_up=cache_programs)
    try:
        for future in [pool.submit(_label, make, asked, batch) for batch in batches]:
            yield future.result()
    except WorkerDied:
        remedy = "the same command goes on; give it fewer --workers"
        raise UsageError(f"a worker process died, maybe for lack of memory; {remedy}") from None
    finally:
        pool.shutdown(cancel_futures=True)


def _label(make: Make, asked: Hashable, batch: Batch) -> list[TrialResult]:
    _warm(make, asked, batch.point.markers, batch.point.method)
    return run_trials(_plan(make, asked), *batch)


@cache
def _plan(make: Make, asked: Hashable) -> ExperimentPlan:
    return make(asked)


@cache
def _warm(make: Make, asked: Hashable, markers: int, method: Method) -> None:
    """Compiles what trials of so many markers need, once a process."""
    plan = _plan(make, asked)
    warm_up(plan, [next(p for p in plan.points if (p.markers, p.method) == (markers, method))])
