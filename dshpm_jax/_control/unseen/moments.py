"""Moments of a recording at which many trajectories are alive, and how the distances between these behave."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._geometry import evenly_spaced, is_seen, pair_distances
from dshpm_jax._marker_set.tuning import SetTuning
from dshpm_jax._trajectories import Trajectories

VOLUME_FRAMES = 16
"""count; used in `Moment`: frames in which signed volumes are measured; by hand."""

MIN_COMMON = 3
"""count; used in `Moment`: frames that two trajectories share, below which their distance says nothing; by hand."""


@dataclass(frozen=True, eq=False)
class Moment:
    """Trajectories that are alive together, and their distances over all frames that they share.

    Attributes:
        frame: when they all are.
        alive: which they are.
        mean, spread: mean and standard deviation of each distance (mm), NaN with too few common frames.
        count: sampled frames that each two share.
        places: where they are in some of the frames (mm), for signed volumes.
    """

    frame: int
    alive: Int[np.ndarray, " points"]
    mean: Float[np.ndarray, "points points"]
    spread: Float[np.ndarray, "points points"]
    count: Int[np.ndarray, "points points"]
    places: Float[np.ndarray, "frames points 3"]


def choose_moments(trajectories: Trajectories, tuning: SetTuning) -> list[Moment]:
    """Moments that together see as much of long lives as they can, the fullest first."""
    t = trajectories
    life = (t.stop - t.start) / t.rate
    long = np.flatnonzero(life >= min(tuning.min_life_seconds, life.max(initial=0.0)))
    weight = np.minimum(life[long], tuning.full_life_seconds)
    chosen: list[int] = []
    most = 0.0
    for _ in range(tuning.max_moments):
        frame, value = _fullest(t, long, weight)
        if value < max(tuning.min_new_share * most, np.finfo(float).tiny):
            break
        most = max(most, value)
        chosen.append(frame)
        weight = np.where((t.start[long] <= frame) & (frame < t.stop[long]), 0.0, weight)
    return [_moment(t, frame, long, tuning) for frame in chosen]


def _fullest(t: Trajectories, which: np.ndarray, weight: np.ndarray) -> tuple[int, float]:
    """The frame with the largest total weight, the middle of the first longest run of such frames."""
    change = np.zeros(t.num_frames + 1)
    np.add.at(change, t.start[which], weight)
    np.add.at(change, t.stop[which], -weight)
    total = np.cumsum(change[:-1])
    best = np.flatnonzero(total >= total.max() - 1e-9)
    runs = np.split(best, np.flatnonzero(np.diff(best) > 1) + 1)
    run = max(runs, key=len)
    return int(run[len(run) // 2]), float(total.max())


def _moment(t: Trajectories, frame: int, long: np.ndarray, tuning: SetTuning) -> Moment:
    alive = long[(t.start[long] <= frame) & (frame < t.stop[long])]
    lives = (t.stop - t.start)[alive]
    alive = np.sort(alive[np.argsort(-lives, kind="stable")[: tuning.max_points]])
    frames = np.arange(int(t.start[alive].min()), int(t.stop[alive].max()))
    step = max(1, round(tuning.moment_seconds * t.rate))
    frames = frames[(frames - frame) % step == 0]
    frames = frames[evenly_spaced(len(frames), tuning.moment_frames)]
    points = t.positions(frames, alive)
    mean, spread, count = behaviour(points)
    full = is_seen(points).sum(1)
    some = np.sort(np.argsort(-full, kind="stable")[: max(VOLUME_FRAMES * 4, int((full >= 0.9 * full.max()).sum()))])
    places = points[some[evenly_spaced(len(some), VOLUME_FRAMES)]]
    return Moment(frame, alive, mean, spread, count, places)


def behaviour(points: Float[np.ndarray, "frames points 3"]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean and standard deviation of all distances, and in how many frames each is seen."""
    count = np.zeros(points.shape[1:2] * 2, int)
    total, square = np.zeros(count.shape), np.zeros(count.shape)
    for part in np.array_split(points, -(-len(points) // 64)):
        distance = pair_distances(part)
        seen = np.isfinite(distance)
        distance = np.where(seen, distance, 0.0)
        count += seen.sum(0)
        total += distance.sum(0)
        square += (distance**2).sum(0)
    known = count >= min(MIN_COMMON, len(points))
    mean = np.where(known, total / np.maximum(count, 1), np.nan)
    variance = np.where(known, square / np.maximum(count, 1) - mean**2, np.nan)
    return mean, np.sqrt(np.maximum(variance, 0.0)), count
