"""Tracking as one would write it with scipy: points predicted by their last step, the best assignment by frame."""

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from dshpm_jax._types import NO_MATCH

GATE = 60.0  # mm that a point may miss its prediction by; to leave both ends free costs as much


def track_by_assignment(points: np.ndarray) -> np.ndarray:
    """For each point the column of the next frame that continues it, or `NO_MATCH`, as `track` gives it."""
    links = np.full(points.shape[:2], NO_MATCH)
    present = np.asarray(np.isfinite(points).all(-1))
    column = np.flatnonzero(present[0])
    position, step = points[0, column], np.zeros((len(column), 3))
    for t in range(1, len(points)):
        here = np.flatnonzero(present[t])
        found = points[t, here]
        cost = np.minimum(cdist(position + step, found), GATE)
        before, after = linear_sum_assignment(cost)
        near = cost[before, after] < GATE
        before, after = before[near], after[near]
        links[t - 1, column[before]] = here[after]
        moved = np.zeros((len(here), 3))
        moved[after] = found[after] - position[before]
        position, step, column = found, moved, here
    return links
