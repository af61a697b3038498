"""Points that leap off for a few frames and come back: reflections, and gaps filled badly, under a sound label."""

import numpy as np
from jaxtyping import Bool, Float

LEAP = 10.0
"""Millimetres by which a point leaves its course in one step, at the least, when it becomes another point."""

SLIPS = (6.0, 8.0)
"""Nats by which the evidence for a label falls below its median over the recording while its point has leapt off."""

LONGEST_SECONDS = 0.2
"""What stays off for longer may be a posture that the model has not seen."""


def leaps(points: Float[np.ndarray, "frames points 3"]) -> Float[np.ndarray, "steps points"]:
    """How far each step leaves the course, the step before once more or standing still (mm); 0 at gaps."""
    step = np.diff(points, axis=0)
    before = np.zeros_like(step)
    before[1:] = np.nan_to_num(step[:-1])
    return np.nan_to_num(np.linalg.norm(step - before, axis=-1))


def slips(
    own: Float[np.ndarray, "frames points"], leap: Float[np.ndarray, "steps points"], rate: float
) -> list[tuple[int, int, int, float]]:
    """Column, first and last frame, and mean fall of the evidence (nats), of every slip.

    Arguments:
        own: evidence for the label of each point, NaN where there is none.
        leap: see `leaps`; a slip begins and ends with one.
        rate: frames a second.
    """
    judged = np.flatnonzero(np.isfinite(own).any(0))
    found = {}
    for column in judged:
        fall = np.nan_to_num(np.nanmedian(own[:, column]) - own[:, column])
        for least in SLIPS:
            for first, last in _runs(fall > least):
                torn = 0 < first and last + 1 < len(own) and min(leap[first - 1, column], leap[last, column]) > LEAP
                if torn and last - first < LONGEST_SECONDS * rate:
                    found.setdefault((int(column), first, last), float(fall[first : last + 1].mean()))
    wide = [k for k in found if not any(k != o and k[0] == o[0] and o[1] <= k[1] and k[2] <= o[2] for o in found)]
    return [(*k, found[k]) for k in sorted(wide)]


def _runs(where: Bool[np.ndarray, " frames"]) -> list[tuple[int, int]]:
    """First and last frame of every run."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2])]
