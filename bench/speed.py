"""How fast is labelling, against reading the same files?

    python bench/speed.py [RECORDING.c3d ... --model model.json] [--quick]

By default eight walks of 600 frames at 60 Hz in 49 markers, 10 % of their points missing and 10 % false ones added. The
recordings are read by ezc3d, read by us and labelled together in turns; labelling counts no file and no compiling.
"""

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path

import ezc3d
import numpy as np
from _rows import Row, show
from _timing import paired

from dshpm_jax import SubjectModel, label_many, read, read_model, write_c3d
from dshpm_jax.synthesis import add_ghosts, open_gaps, person, scramble

MARKERS, RECORDINGS, FRAMES = 49, 8, 600


def make(folder: Path) -> tuple[list[Path], SubjectModel]:
    """Worn walks of one person, and the model."""
    paths = []
    for k in range(RECORDINGS):
        rng = np.random.default_rng(k)
        walk = person(MARKERS, "walking", FRAMES, seed=k).recording
        paths.append(folder / f"walk{k}.c3d")
        write_c3d(scramble(add_ghosts(open_gaps(walk, 0.1, rng), 0.1, rng), rng)[0], paths[-1])
    return paths, SubjectModel.from_recordings([person(MARKERS, "freeform", FRAMES, seed=99).recording])


def contest(paths: list[Path], model: SubjectModel, runs: int) -> Iterator[Row]:
    recordings = [read(path) for path in paths]
    list(label_many(recordings, model))  # compiles
    times, ratios = paired(
        [
            lambda: [ezc3d.c3d(str(path)) for path in paths],
            lambda: [read(path) for path in paths],
            lambda: list(label_many(recordings, model)),
        ],
        runs,
    )
    frames = sum(recording.num_frames for recording in recordings)
    points = np.mean([recording.present.sum(1).mean() for recording in recordings])
    case = f"{len(recordings)} recordings, {points:.0f} points a frame"
    yield Row(case, "labelling / ezc3d reading", ratios[2], at_most=1.0)
    yield Row(case, "our reading / ezc3d reading", ratios[1])
    for name, seconds in zip(("ezc3d reads", "we read", "we label"), times):
        yield Row(case, f"{name} (frames/s)", frames / seconds)


def rows(quick: bool) -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder:
        yield from contest(*make(Path(folder)), 1 if quick else 5)


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("recordings", nargs="*", type=Path, metavar="RECORDING")
    parser.add_argument("--model", type=Path)
    parser.add_argument("--quick", action="store_true", help="a single run")
    arguments = parser.parse_args()
    if bool(arguments.recordings) != bool(arguments.model):
        parser.error("recordings need --model, and a model needs recordings")
    if arguments.recordings:
        show(contest(arguments.recordings, read_model(arguments.model), 3))
    else:
        show(rows(arguments.quick))


if __name__ == "__main__":
    main()
