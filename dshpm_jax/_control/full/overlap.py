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
