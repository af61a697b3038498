"""Which trajectories share a frame, without a table of all pairs: a long recording has tens of thousands of them."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool, Int

ROWS = 256  # trajectories in a block


def overlap_blocks(
    start: Int[np.ndarray, " trajectories"], stop: Int[np.ndarray, " trajectories"]
) -> Iterator[tuple[Int[np.ndarray, " rows"], Int[np.ndarray, " near"], Bool[np.ndarray, "rows near"]]]:
    """Some trajectories at a time, all that share a frame with any of them, and which do so with which.

    None does with itself. Numbers ascend, in a block and from block to block; blocks are small where trajectories
    are numbered by their first frames.
    """
    for first in range(0, len(start), ROWS):
        rows = np.arange(first, min(first + ROWS, len(start)))
        near = np.flatnonzero((start < stop[rows].max()) & (start[rows].min() < stop))
        together = (start[rows, None] < stop[near]) & (start[near] < stop[rows, None])
        yield rows, near, together & (rows[:, None] != near)


def chains(
    start: Int[np.ndarray, " trajectories"], stop: Int[np.ndarray, " trajectories"]
) -> list[Int[np.ndarray, " chain"]]:
    """The trajectories in groups that hang together through overlaps in time, each ascending, by their first ones."""
    order = np.lexsort((np.arange(len(start)), start))
    until = np.maximum.accumulate(stop[order])
    begins = np.flatnonzero(start[order][1:] >= until[:-1]) + 1
    return sorted((np.sort(group) for group in np.split(order, begins) if len(group)), key=lambda group: group[0])
