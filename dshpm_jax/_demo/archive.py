"""A small archive to try every command on: three subjects, a duet, a static, and files with something wrong."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from dshpm_jax import io
from dshpm_jax._demo.folder import is_free
from dshpm_jax._recording import Recording
from dshpm_jax.synthesis import add_ghosts, open_gaps, person, scramble

FOLDER = Path("dshpm-archive")
SUBJECTS = {"anna": 1, "ben": 2, "carl": 3}  # and whose body each has (see `person`)
UNLABELLED = {"walk.c3d": "walking", "run.c3d": "running"}
DUET = {"anna": "walking", "ben": "freeform"}
MARKERS, RATE = 34, 60.0
MOTION_SECONDS, UNLABELLED_SECONDS, STATIC_SECONDS = 5.0, 3.0, 2.0
GAPS, GHOSTS = 0.1, 0.1  # of the points
APART = 500.0  # mm, between the two of the duet
EXCHANGED = ("LELB", "LWRA")
EXCHANGED_SECONDS = (1.0, 2.0)  # from and to
KEPT_BYTES = 0.6  # of the damaged file
SEED = 2008

README = f"""\
A small archive to try every command of dshpm-jax on. Everything in it is made: no such people, no such recordings.
Three subjects, {MARKERS} markers each, {RATE:g} Hz. "Unlabelled": {GAPS:.0%} of the points are lost in gaps,
{GHOSTS:.0%} false ones are added, and no point has a name.

anna/labelled.c3d    labelled, range of motion, {MOTION_SECONDS:g} s: for the model of anna
anna/static.c3d      labelled, anna stands still
anna/walk.c3d        unlabelled
anna/run.c3d         unlabelled
ben/labelled.c3d     labelled, range of motion: for the model of ben
ben/walk.c3d         unlabelled
ben/run.c3d          unlabelled
ben/exchanged.c3d    labelled, but {" and ".join(EXCHANGED)} are exchanged for a second
carl/labelled.c3d    labelled, range of motion: for the model of carl
carl/walk.c3d        unlabelled
carl/run.c3d         unlabelled
carl/damaged.c3d     a file that ends too early, as after a copy that was interrupted
duet/duet.c3d        unlabelled, anna and ben side by side

To begin with, in this folder:

    dshpm-jax model anna/labelled.c3d -o anna/model.json
    dshpm-jax model ben/labelled.c3d -o ben/model.json
    dshpm-jax model carl/labelled.c3d -o carl/model.json
    dshpm-jax label . -o labelled
    dshpm-jax label duet --model anna/model.json --model ben/model.json -o labelled-duet
    dshpm-jax view labelled/anna/walk.c3d
    dshpm-jax check ben/exchanged.c3d --model ben/model.json
    dshpm-jax reconstruct labelled/anna/walk.c3d --model anna/model.json -o motion

"label ." fails for two files, as it should: the damaged one, and the duet, which needs two models.
"""


def run(out: Path | None = None) -> int:
    """Writes the archive into `out` and says what it wrote; gives the exit status."""
    folder = FOLDER if out is None else out
    if not is_free(folder):
        return 1
    written = write_archive(folder)
    print(f"in {folder}: {', '.join(path.relative_to(folder).as_posix() for path in written)}")
    return 0


def write_archive(folder: Path) -> list[Path]:
    """Writes the archive into `folder`, the same files every time; gives the files in the order of their names."""
    rng = np.random.default_rng(SEED)
    for name in SUBJECTS:
        _write(_taken(name, "freeform", MOTION_SECONDS), folder / name / "labelled.c3d")
        for file, activity in UNLABELLED.items():
            _write(_unlabelled(_taken(name, activity, UNLABELLED_SECONDS), rng), folder / name / file)
    _write(_taken("anna", "standing", STATIC_SECONDS), folder / "anna" / "static.c3d")
    _write(_exchanged(_taken("ben", "walking", UNLABELLED_SECONDS, seed=1)), folder / "ben" / "exchanged.c3d")
    _write_damaged(_taken("carl", "walking", UNLABELLED_SECONDS, seed=1), folder / "carl" / "damaged.c3d")
    _write(_unlabelled(_duet(), rng), folder / "duet" / "duet.c3d")
    (folder / "README.txt").write_text(README)
    return sorted(path for path in folder.rglob("*") if path.is_file())


def _taken(name: str, activity: str, seconds: float, seed: int = 0) -> Recording:
    """A labelled take of one subject; takes that differ in `seed` are of different movements."""
    return person(MARKERS, activity, round(seconds * RATE), RATE, SUBJECTS[name], SEED + seed).recording


def _unlabelled(recording: Recording, rng: np.random.Generator) -> Recording:
    """The recording with gaps, ghosts and no names."""
    return scramble(add_ghosts(open_gaps(recording, GAPS, rng), GHOSTS, rng), rng)[0]


def _duet() -> Recording:
    """Two subjects side by side; each moves as if alone."""
    left, right = (_taken(name, activity, UNLABELLED_SECONDS, seed=2) for name, activity in DUET.items())
    shift = left.points[..., 1].max() + APART - right.points[..., 1].min()
    points = np.concatenate([left.points, right.points + (0, shift, 0)], axis=1)
    labels = [f"{name}:{label}" for name, one in zip(DUET, (left, right), strict=True) for label in one.labels]
    return Recording(points, tuple(labels), RATE)


def _exchanged(recording: Recording) -> Recording:
    """The recording with two labels exchanged for a while."""
    first, last = (round(seconds * RATE) for seconds in EXCHANGED_SECONDS)
    one, other = (recording.labels.index(label) for label in EXCHANGED)
    points = np.array(recording.points)
    points[first:last, [one, other]] = points[first:last, [other, one]]
    return replace(recording, points=points)


def _write(recording: Recording, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    io.write_c3d(recording, path)


def _write_damaged(recording: Recording, path: Path) -> None:
    """Writes a file and cuts its end off."""
    _write(recording, path)
    whole = path.read_bytes()
    path.write_bytes(whole[: round(KEPT_BYTES * len(whole))])
