"""How does the time of labelling grow with points, frames, recordings and ghosts?

    python bench/scaling.py [--quick] [--only points|frames|recordings|ghosts ...]

Worn walks at 60 Hz: a tenth of the points missing, a tenth of false ones added. Points grow by people of 30 markers
side by side, or by ghosts among the 49 markers of one. Recordings of 600 frames go through one call. Runs in which
anything was compiled do not count. The exponent is the slope of the times on logarithmic axes.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from _rows import Row, show
from _timing import exponent, warm_seconds

from dshpm_jax import Recording, SubjectModel, combine_models, label_many
from dshpm_jax.synthesis import add_ghosts, open_gaps, person, scramble

MARKERS, OF_SEVERAL, FRAMES, WORN = 49, 30, 600, 0.1
APART = 1500.0  # mm between two people
DISTINCT = 8  # recordings, or pieces of a long one; more are the same again
PIECE = 2000  # frames

Work = tuple[list[Recording], SubjectModel]


def worn(take: Recording, seed: int, ghosts: float = WORN) -> Recording:
    rng = np.random.default_rng(seed)
    return scramble(add_ghosts(open_gaps(take, WORN, rng), ghosts, rng, near=True), rng)[0]


@cache
def model_of(markers: int, subject: int = 0) -> SubjectModel:
    return SubjectModel.from_recordings([person(markers, "freeform", 900, subject=subject, seed=99).recording])


@cache
def walk(frames: int = FRAMES, seed: int = 0, ghosts: float = WORN) -> Recording:
    return worn(person(MARKERS, "walking", frames, seed=seed).recording, seed, ghosts)


def several_people(points: float) -> Work:
    people = round(points) // OF_SEVERAL
    takes = [person(OF_SEVERAL, "walking", FRAMES, subject=k, seed=k).recording for k in range(people)]
    places = np.concatenate([take.points + (0, APART * k, 0) for k, take in enumerate(takes)], axis=1)
    names = tuple(f"{k}:{label}" for k, take in enumerate(takes) for label in take.labels)
    models = {str(k): model_of(OF_SEVERAL, k) for k in range(people)}
    return [worn(replace(takes[0], points=places, labels=names), 0)], combine_models(models)


def more_ghosts(points: float) -> Work:
    return [walk(ghosts=points / MARKERS - (1 - WORN))], model_of(MARKERS)


def more_frames(frames: float) -> Work:
    """A long recording goes on in the same columns after a while, as capture systems do; else there are too many."""
    pieces = [walk(round(min(frames, PIECE)), seed=k % DISTINCT).points for k in range(-(-round(frames) // PIECE))]
    width = max(piece.shape[1] for piece in pieces)
    points = np.full((round(frames), width, 3), np.nan)
    for k, piece in enumerate(pieces):
        part = points[k * PIECE : (k + 1) * PIECE, : piece.shape[1]]
        part[:] = piece[: len(part)]
    return [replace(walk(), points=points, labels=("",) * width, columns=())], model_of(MARKERS)


def more_recordings(count: float) -> Work:
    return [walk(seed=k % DISTINCT) for k in range(round(count))], model_of(MARKERS)


# what grows: how it is made, its sizes, those of a quick run, those that the exponent is fitted on, and its aim
GROWTHS: dict[str, tuple[Callable[[float], Work], Sequence[int], Sequence[int], tuple[float, float], float]] = {
    "points": (several_people, (30, 60, 90, 120, 150), (60, 120), (60, 120), 1.5),
    "ghosts": (more_ghosts, (54, 60, 90, 120, 150), (60, 120), (60, 120), 1.5),
    "frames": (more_frames, (600, 2000, 6000, 20000, 60000), (600, 1200, 2400), (0, np.inf), 1.05),
    "recordings": (more_recordings, (1, 10, 100, 1000), (1, 4, 8), (0, np.inf), 1.0),
}


def rows(quick: bool, only: Sequence[str] = tuple(GROWTHS), most: float = np.inf) -> Iterator[Row]:
    for what in only:
        make, full, short, (low, high), aim = GROWTHS[what]
        sizes = [size for size in (short if quick else full) if size <= most]
        times = []
        for size in sizes:
            recordings, model = make(size)
            times.append(warm_seconds(lambda: list(label_many(recordings, model)), 1 if quick else 3))
            yield Row(f"{what}, {size}", f"time against {what} (s)", times[-1], size=size)
        fitted = [(size, spent) for size, spent in zip(sizes, times) if low <= size <= high]
        if len(fitted) > 1:
            span = f"{fitted[0][0]} to {fitted[-1][0]} {what}"
            yield Row(span, "exponent of time", exponent(*zip(*fitted)), at_most=aim)


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", nargs="+", choices=GROWTHS, default=list(GROWTHS))
    parser.add_argument("--most", type=float, default=np.inf, help="leave out larger sizes than this")
    arguments = parser.parse_args()
    show(rows(arguments.quick, arguments.only, arguments.most))


if __name__ == "__main__":
    main()
