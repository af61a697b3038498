"""How many frames a second are tracked, and how many links are wrong?

    python bench/tracking.py [RECORDING.c3d ...] [--every N]

Each labelled recording (by default figures made on the spot) is thinned to every Nth frame, its points are shuffled in
each frame, and the links are compared with the columns that they came from. Compiling is not counted.
On two shared CPU cores, jax 0.10:

    made on the spot   28 points  100 Hz     6125 frames/s  wrong 0 of 27972, missed 0.00%
    made on the spot   60 points  100 Hz     2172 frames/s  wrong 0 of 59940, missed 0.00%
    made on the spot  120 points  100 Hz      760 frames/s  wrong 0 of 119880, missed 0.00%
"""

import argparse
import time
from pathlib import Path

import numpy as np

from dshpm_jax._kernels.tracking import track
from dshpm_jax._types import NO_MATCH


def crowd(points: int, frames: int = 1000, rate: float = 100.0) -> np.ndarray:
    """Points that cross a room together at walking speed, each swinging by itself."""
    rng = np.random.default_rng(0)
    t = np.arange(frames)[:, None, None] / rate
    swing = rng.normal(0, 60, (points, 3)) * np.sin(2 * np.pi * t * rng.uniform(0.5, 2, (points, 3)))
    return rng.uniform(0, 1800, (points, 3)) + swing + t * np.array([1500, 0, 0])


def shuffle(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same points with the columns of each frame permuted, and the column that each came from."""
    rng = np.random.default_rng(0)
    identity = np.argsort(rng.random(points.shape[:2]), axis=1)
    return np.take_along_axis(points, identity[..., None], axis=1), identity


def measure(name: str, points: np.ndarray, rate: float) -> None:
    mixed, identity = shuffle(points)
    track(mixed[:2], rate)  # compiles
    start = time.perf_counter()
    links = track(mixed, rate)
    seconds = time.perf_counter() - start
    present = np.asarray(np.isfinite(points).all(-1))
    possible = np.logical_and(present[1:], present[:-1]).sum()
    t, i = np.nonzero(links != NO_MATCH)
    right = (identity[t, i] == identity[t + 1, links[t, i]]).sum()
    print(
        f"{name:28} {points.shape[1]:4} points {rate:4.0f} Hz {len(points) / seconds:8.0f} frames/s  "
        f"wrong {len(t) - right} of {len(t)}, missed {1 - right / possible:.2%}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="*", type=Path)
    parser.add_argument("--every", type=int, default=1)
    arguments = parser.parse_args()
    if not arguments.recordings:
        for points in (28, 60, 120):
            measure("made on the spot", crowd(points)[:: arguments.every], 100.0 / arguments.every)
    for path in arguments.recordings:
        from dshpm_jax.io import read

        recording = read(path)
        points = recording.points[:: arguments.every, recording.labelled]
        measure(path.name, points, recording.rate / arguments.every)


if __name__ == "__main__":
    main()
