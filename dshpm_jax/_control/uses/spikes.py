"""Points that leap off for a few frames and come back: reflections, and gaps filled badly, under a sound label."""

import numpy as np
from jaxtyping import Float

from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._geometry import is_seen, runs


def leaps(points: Float[np.ndarray, "frames points 3"]) -> Float[np.ndarray, "steps points"]:
    """How far each step leaves the course, the step before once more or standing still (mm); 0 at gaps."""
    step = np.diff(points, axis=0)
    before = np.zeros_like(step)
    before[1:] = np.nan_to_num(step[:-1])
    return np.nan_to_num(np.linalg.norm(step - before, axis=-1))


def spikes(
    own: Float[np.ndarray, "frames points"],
    points: Float[np.ndarray, "frames points 3"],
    rate: float,
    tuning: Tuning = TUNING,
) -> list[tuple[int, int, int, float]]:
    """Column, first and last frame, and mean fall of the evidence (nats), of every spike.

    Arguments:
        own: evidence for the label of each point, NaN where there is none.
        points: places (mm); a spike begins and ends with a leap.
        rate: frames a second.
    """
    leap = leaps(points)
    judged = np.flatnonzero(np.isfinite(own).any(0))
    found = {}
    for column in judged:
        fall = np.nan_to_num(np.nanmedian(own[:, column]) - own[:, column])
        for least in tuning.spike_llr:
            for first, stop in runs(fall > least):
                last = stop - 1
                torn = (
                    0 < first
                    and last + 1 < len(own)
                    and min(leap[first - 1, column], leap[last, column]) > tuning.leap_mm
                )
                short = last - first < tuning.max_spike_seconds * rate
                if torn and short and _off_its_way(points[:, column], first, last, tuning) > tuning.min_spike_mm:
                    found.setdefault((int(column), first, last), float(fall[first : last + 1].mean()))
    wide = [k for k in found if not any(k != o and k[0] == o[0] and o[1] <= k[1] and k[2] <= o[2] for o in found)]
    return [(*k, found[k]) for k in sorted(wide)]


def _off_its_way(points: Float[np.ndarray, "frames 3"], first: int, last: int, tuning: Tuning) -> float:
    """How far a point is from its way at most (mm), 0 where too little of that is seen."""
    context = tuning.spike_context
    begin, end = max(0, first - context), min(len(points), last + 1 + context)
    around = np.setdiff1d(np.arange(begin, end), np.arange(first, last + 1))
    around = around[is_seen(points[around])]
    if len(around) <= context:
        return 0.0
    here = np.arange(first, last + 1)
    way = np.vander(here - first, 3) @ np.polyfit(around - first, points[around], 2)
    return float(np.linalg.norm(way - points[here], axis=-1).max())
