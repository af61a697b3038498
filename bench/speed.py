"""How fast is labelling, against reading the same files?

    python bench/speed.py [RECORDING.c3d ... --model model.json] [--runs 3]

By default eight walks of 600 frames at 60 Hz in 49 markers, 10 % of their points missing and 10 % false ones added. The
recordings are read by ezc3d, read by us and labelled together in turns; labelling counts no file and no compiling.
On two shared CPU cores of which others took a good part, jax 0.10:

    8 recordings, 4800 frames, 49 points a frame
    ezc3d reads       3684 frames/s      1.00 times what ezc3d takes
    we read          29554 frames/s      0.16 times what ezc3d takes
    we label           292 frames/s     13.44 times what ezc3d takes
    peak memory 0.66 GB
"""

import argparse
import resource
import tempfile
from pathlib import Path

import ezc3d
import numpy as np
from _timing import paired

from dshpm_jax import Recording, SubjectModel, label_many, read, read_model, write_c3d
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


def report(recordings: list[Recording], times: list[float], ratios: list[float]) -> None:
    frames = sum(recording.num_frames for recording in recordings)
    points = np.mean([recording.present.sum(1).mean() for recording in recordings])
    print(f"{len(recordings)} recordings, {frames} frames, {points:.0f} points a frame")
    for name, seconds, ratio in zip(("ezc3d reads", "we read", "we label"), times, ratios):
        print(f"{name:12} {frames / seconds:9.0f} frames/s   {ratio:7.2f} times what ezc3d takes")
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GB")


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("recordings", nargs="*", type=Path, metavar="RECORDING")
    parser.add_argument("--model", type=Path)
    parser.add_argument("--runs", type=int, default=3)
    arguments = parser.parse_args()
    if bool(arguments.recordings) != bool(arguments.model):
        parser.error("recordings need --model, and a model needs recordings")
    with tempfile.TemporaryDirectory() as folder:
        paths, model = arguments.recordings, arguments.model and read_model(arguments.model)
        if model is None:
            paths, model = make(Path(folder))
        recordings = [read(path) for path in paths]
        list(label_many(recordings, model))  # compiles
        times, ratios = paired(
            [
                lambda: [ezc3d.c3d(str(path)) for path in paths],
                lambda: [read(path) for path in paths],
                lambda: list(label_many(recordings, model)),
            ],
            arguments.runs,
        )
    report(recordings, times, ratios)


if __name__ == "__main__":
    main()
