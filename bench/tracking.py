"""How fast are raw points tracked, and how many links are right, beside scipy's assignment with prediction?

    python bench/tracking.py [RECORDING.c3d ... [--every N]] [--quick]

Each labelled recording (by default crowds made on the spot) is thinned to every Nth frame, its points are shuffled in
each frame, and the links are compared with the columns that they came from. Compiling is not counted. Scipy's loop
goes through the recording once, ours forwards and backwards.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from _rows import Row, show
from _scipy_tracking import track_by_assignment
from _timing import paired

from dshpm_jax import read
from dshpm_jax._kernels.tracking import track
from dshpm_jax._types import NO_MATCH

RATE = 100.0  # Hz, of the crowds


def crowd(points: int, frames: int) -> np.ndarray:
    """Points that cross a room together at walking speed, each swinging by itself."""
    rng = np.random.default_rng(0)
    t = np.arange(frames)[:, None, None] / RATE
    swing = rng.normal(0, 60, (points, 3)) * np.sin(2 * np.pi * t * rng.uniform(0.5, 2, (points, 3)))
    return rng.uniform(0, 1800, (points, 3)) + swing + t * np.array([1500, 0, 0])


def shuffle(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same points with the columns of each frame permuted, and the column that each came from."""
    rng = np.random.default_rng(0)
    identity = np.argsort(rng.random(points.shape[:2]), axis=1)
    return np.take_along_axis(points, identity[..., None], axis=1), identity


def contest(case: str, points: np.ndarray, rate: float, runs: int) -> Iterator[Row]:
    mixed, identity = shuffle(points)
    ours = track(mixed, rate)  # compiles
    (seconds, _), (_, ratio) = paired([lambda: track(mixed, rate), lambda: track_by_assignment(mixed)], runs)
    yield Row(case, "assignment / ours", ratio, at_least=8.0)
    yield Row(case, "ours (frames/s)", len(points) / seconds)
    present = np.asarray(np.isfinite(points).all(-1))
    possible = np.logical_and(present[1:], present[:-1]).sum()
    right = [links_right(links, identity) for links in (ours, track_by_assignment(mixed))]
    recalls = [count / possible for count, _ in right]
    yield Row(case, "recall", recalls[0])
    yield Row(case, "recall lacks of the assignment's", recalls[1] - recalls[0], at_most=0.001)
    for name, (count, links) in zip(("ours", "the assignment's"), right):
        yield Row(case, f"wrong links, {name}", links - count)


def links_right(links: np.ndarray, identity: np.ndarray) -> tuple[int, int]:
    """How many links are right, and how many there are."""
    t, i = np.nonzero(links != NO_MATCH)
    return int((identity[t, i] == identity[t + 1, links[t, i]]).sum()), len(t)


def rows(quick: bool) -> Iterator[Row]:
    frames, runs = (1000, 3) if quick else (5000, 7)
    for points in (60,) if quick else (28, 60, 120):
        yield from contest(f"{points} points made on the spot", crowd(points, frames), RATE, runs)


def of_files(paths: list[Path], every: int, runs: int) -> Iterator[Row]:
    for path in paths:
        recording = read(path)
        points = recording.points[::every, recording.labelled]
        yield from contest(f"{points.shape[1]} points of {path.name}", points, recording.rate / every, runs)


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("recordings", nargs="*", type=Path)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    show(of_files(arguments.recordings, arguments.every, 3) if arguments.recordings else rows(arguments.quick))


if __name__ == "__main__":
    main()
