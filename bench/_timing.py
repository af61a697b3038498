"""Times of several contestants that run in turns, so that what slows the machine slows all of them."""

import time
from collections.abc import Callable, Sequence
from statistics import median


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
