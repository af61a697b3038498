"""A synthetic archive: how well, how fast and in how much memory it is labelled.

    python bench/archive.py FOLDER [--recordings 100] [--workers 2] [--also OTHERS]

makes FOLDER/captures (five marker sets, 20 subjects, each with a model; a tenth of the points of every recording lost
in gaps, a tenth of false ones added, no names) and FOLDER/truth, where they are not there yet, and labels it into
FOLDER/labelled, which must not be there yet.

`--also` takes recordings of your own along, with their models: OTHERS/captures and OTHERS/truth, laid out like those of
FOLDER, are copied there. The truth of `captures/a/b.c3d` is `truth/a.b.npz`, with `labels`, `xyz` (frames, labels, 3),
`units` and `judged` (frames, labels).
"""

import argparse
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil
from _machine import peak_memory
from _truth import NEAR, places_of

from dshpm_jax import SubjectModel, read, write_c3d, write_model
from dshpm_jax.synthesis import Synthetic, add_ghosts, hand, open_gaps, person, robot_arm, scramble

SUBJECTS, GAPS, GHOSTS, RATE = 20, 0.1, 0.1, 60.0
MODEL_FRAMES, LEAST_FRAMES, MOST_FRAMES = 900, 300, 600
ACTIVITIES = ("walking", "running", "freeform")
SETS = ("27 markers", "34 markers", "49 markers", "robot arm", "hand")


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--recordings", type=int, default=100)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--also", type=Path, metavar="OTHERS", help="folder with captures and truth of your own")
    arguments = parser.parse_args()
    folder = arguments.folder
    if (folder / "labelled").exists():
        raise SystemExit(f"{folder / 'labelled'} is there: move it away")
    make(folder, arguments.recordings)
    for part in ("captures", "truth") if arguments.also else ():
        shutil.copytree(arguments.also / part, folder / part, dirs_exist_ok=True)
    command = label_command(folder, folder / "labelled", "--workers", str(arguments.workers))
    start = time.perf_counter()
    with (folder / "run.txt").open("w") as lines, subprocess.Popen(command, stdout=lines) as process:
        peaks = watch(process)
    seconds = time.perf_counter() - start
    print(f"exit status {process.returncode}, {arguments.workers} workers, {seconds:.0f} s")
    scores = dict(score(folder))
    frames = sum(frames for _, frames in scores.values())
    print(f"{len(scores)} files, {frames} frames, {frames / seconds:.0f} frames/s, starting and compiling included")
    for kind in sorted({Path(name).parts[0] for name in scores}):
        found = [f1 for name, (f1, _) in scores.items() if Path(name).parts[0] == kind]
        print(f"{kind:28} {len(found):5} files, mean F1 {np.mean(found):.4f}, lowest {min(found):.4f}")
    print("peak memory of the processes (MB):", " ".join(f"{peak / 1e6:.0f}" for peak in sorted(peaks, reverse=True)))


def make(folder: Path, recordings: int) -> None:
    """The archive and its truth; what is there stays."""
    for subject in range(SUBJECTS):
        place = folder / "captures" / SETS[subject % len(SETS)] / f"subject {subject:02}"
        place.mkdir(parents=True, exist_ok=True)
        if not (place / "model.json").exists():
            model = SubjectModel.from_recordings([synthetic(subject, MODEL_FRAMES, "freeform", 10_000).recording])
            write_model(model, place / "model.json")
    (folder / "truth").mkdir(exist_ok=True)
    for k in range(recordings):
        make_recording(folder, k)


def make_recording(folder: Path, k: int) -> None:
    rng = np.random.default_rng([k, 7])
    subject, activity = k % SUBJECTS, ACTIVITIES[int(rng.integers(len(ACTIVITIES)))]
    path = Path(SETS[subject % len(SETS)]) / f"subject {subject:02}" / f"{activity} {k:04}.c3d"
    if (folder / "captures" / path).exists():
        return
    clean = synthetic(subject, int(rng.integers(LEAST_FRAMES, MOST_FRAMES + 1)), activity, k).recording
    spoilt = add_ghosts(open_gaps(clean, GAPS, rng), GHOSTS, rng)
    places = spoilt.points[:, : len(clean.labels)]
    labels, judged = np.array(clean.labels), np.ones(places.shape[:2], bool)
    np.savez_compressed(truth_of(folder, path), labels=labels, xyz=places, units="mm", judged=judged)
    write_c3d(scramble(spoilt, rng)[0], folder / "captures" / path)


def synthetic(subject: int, frames: int, activity: str, seed: int) -> Synthetic:
    kind = SETS[subject % len(SETS)]
    if kind == "robot arm":
        return robot_arm(frames, RATE, subject, seed)
    if kind == "hand":
        return hand(frames, RATE, subject, seed)
    return person(int(kind.split()[0]), activity, frames, RATE, subject, seed)


def truth_of(folder: Path, recording: Path) -> Path:
    """Where the truth about a recording is, as `reliability.py` wants it."""
    return folder / "truth" / (".".join(recording.with_suffix("").parts) + ".npz")


def label_command(folder: Path, out: Path, *options: str) -> list[str]:
    return [sys.executable, "-m", "dshpm_jax", "label", str(folder / "captures"), "-o", str(out), *options]


def watch(process: subprocess.Popen, seconds: float = 1.0) -> list[int]:
    """Waits for a run to end; the peak memory of each of its processes that lived for more than a moment (bytes)."""
    peaks: dict[int, int] = {}
    while process.poll() is None:
        for one in family(process.pid):
            peaks[one] = max(peaks.get(one, 0), peak_memory(one))
        time.sleep(seconds)
    return [peak for peak in peaks.values() if peak]


def family(pid: int) -> list[int]:
    """A process and all that it started."""
    try:
        return [pid, *(child.pid for child in psutil.Process(pid).children(recursive=True))]
    except psutil.NoSuchProcess:
        return []


def score(folder: Path) -> Iterator[tuple[str, tuple[float, int]]]:
    """F1 over points, and the number of frames, of each recording."""
    for path in sorted((folder / "captures").rglob("*.c3d")):
        name = path.relative_to(folder / "captures")
        truth = dict(np.load(truth_of(folder, name)))
        places = places_of(truth)
        there = int((np.isfinite(places).all(-1) & truth["judged"]).sum())
        labelled = folder / "labelled" / name
        if not labelled.exists():
            yield str(name), (0.0, len(places))
            continue
        found = read(labelled)
        given = np.full(places.shape, np.nan)
        for k, label in enumerate(truth["labels"]):
            if label in found.labels:  # a model need not have all that is known
                given[:, k] = found.points[:, found.labels.index(label)]
        with np.errstate(invalid="ignore"):
            right = int(((np.linalg.norm(given - places, axis=-1) < NEAR) & truth["judged"]).sum())
        named = int((np.isfinite(given).all(-1) & truth["judged"]).sum())
        yield str(name), (2.0 * right / max(1, there + named), len(places))


if __name__ == "__main__":
    os.environ.setdefault("PYTHONUNBUFFERED", "1")
    main()
