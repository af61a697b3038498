"""How does a run grow with the number of its trials?

    python bench/many.py FOLDER [--trials 2000] [--frames 60] [--no-pages]

makes FOLDER/captures, twenty folders of trials of a person of 34 markers: one worn take, in each trial somewhere else
in the room. `label` labels them into FOLDER/labelled and then has nothing to do. It prints for both runs the seconds,
those of a processor and the memory at the peak, and the sizes of what the folder of results holds.
"""

import argparse
import os
import resource
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from dshpm_jax import SubjectModel, write_c3d, write_model
from dshpm_jax.synthesis import add_ghosts, open_gaps, person, scramble

FOLDERS, MARKERS, RATE, WORN, ROOM_MM = 20, 34, 60.0, 0.1, 1000.0
KINDS = ("report.html", "summary.csv", "manifest.jsonl", "*.c3d", "*.labels.json", "*.html")


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--trials", type=int, default=2000)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--no-pages", action="store_true")
    arguments = parser.parse_args()
    captures, out = arguments.folder / "captures", arguments.folder / "labelled"
    if out.exists():
        raise SystemExit(f"{out} is there: move it away")
    make(captures, arguments.trials, arguments.frames)
    command = [sys.executable, "-m", "dshpm_jax", "label", str(captures), "-o", str(out)]
    command += ["--no-pages"] if arguments.no_pages else []
    for what in ("all to do", "nothing to do"):
        start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        with open(os.devnull, "w") as nowhere:
            status = subprocess.run(command, stdout=nowhere, stderr=nowhere).returncode
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime
        seconds = time.perf_counter() - start
        print(f"{what}: status {status}, {seconds:.1f} s, {cpu:.1f} s of a processor, {used.ru_maxrss / 1e3:.0f} MB")
    for kind in KINDS:
        sizes = [path.stat().st_size for path in (out.rglob(kind) if "*" in kind else out.glob(kind))]
        print(f"{kind}: {len(sizes)} of {sum(sizes) / 1e6:.2f} MB")


def make(captures: Path, trials: int, frames: int) -> None:
    """The archive; each trial differs from all others in every coordinate."""
    rng = np.random.default_rng(0)
    model = SubjectModel.from_recordings([person(MARKERS, "freeform", 600, RATE, 1, 0).recording])
    for k in range(FOLDERS):
        folder = captures / f"subject {k:02}"
        folder.mkdir(parents=True, exist_ok=True)
        write_model(model, folder / "model.json")
    take = person(MARKERS, "walking", frames, RATE, 1, 1).recording
    worn = scramble(add_ghosts(open_gaps(take, WORN, rng), WORN, rng), rng)[0]
    for k in range(trials):
        shift = rng.uniform(-ROOM_MM, ROOM_MM, 3) * (1, 1, 0)
        write_c3d(replace(worn, points=worn.points + shift), captures / f"subject {k % FOLDERS:02}" / f"{k:06}.c3d")


if __name__ == "__main__":
    main()
