"""Times of several contestants that run in turns, so that what slows the machine slows all of them."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from statistics import median

import numpy as np
from jax import monitoring

COMPILED = "/jax/core/compile/backend_compile_duration"  # the event that jax tells of for each program
MOST_COMPILING = 3  # runs
LONG = 120.0  # seconds; no more runs once those that count took so long


def seconds(function: Callable[[], object]) -> float:
    """One run; `function` returns only when its result is there."""
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def paired(functions: Sequence[Callable[[], object]], runs: int) -> tuple[list[float], list[float]]:
    """Median seconds of each function, and the median over the runs of each one's time over the first one's."""
    times = [[seconds(function) for function in functions] for _ in range(runs)]
    columns = list(zip(*times))
    return [median(column) for column in columns], [median(x / row[0] for x, row in zip(c, times)) for c in columns]


@contextmanager
def compiling() -> Iterator[list[float]]:
    """The seconds that each program took which was compiled meanwhile; one found in the compile cache counts too."""
    found: list[float] = []

    def hear(event: str, duration_secs: float, **_) -> None:
        if event == COMPILED:
            found.append(duration_secs)

    monitoring.register_event_duration_secs_listener(hear)
    try:
        yield found
    finally:
        monitoring.unregister_event_duration_listener(hear)


def warm_seconds(function: Callable[[], object], runs: int) -> float:
    """Median seconds of `function` without compiling: runs in which anything was compiled do not count.

    Of as many `runs`, or as few as take `LONG` together.
    """
    times: list[float] = []
    for _ in range(runs + MOST_COMPILING):
        with compiling() as programs:
            spent = seconds(function)
        times += [] if programs else [spent]
        if len(times) == runs or sum(times) > LONG:
            return median(times)
    raise RuntimeError(f"something was compiled in more than {MOST_COMPILING} of {runs + MOST_COMPILING} runs")


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float:
    """The power of the size that the times grow with, fitted on logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])
