"""Do other readers have the points that we read from C3D files whose header and parameters disagree?

    python bench/disagreeing.py [--files 500] [--seed 0] [--keep FOLDER]

Makes small sound files of floating point numbers and of integers, with and without analog samples, and writes another
number over one or two of those that say how long a record is and how many there are: in the header, in a parameter or
in both. Each must be refused, or give points that ezc3d or c3d have as well, or those that were written. Files for
which nobody else has our points are kept in FOLDER, and the exit status is 1.
"""

import argparse
import multiprocessing
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from dshpm_jax import Recording, io
from dshpm_jax.io._c3d import fresh_layout
from dshpm_jax.io._c3d_format import C3dFile, write_layout
from dshpm_jax.io._c3d_parameters import FLOAT, INT, Parameter, encode_floats, integers, with_parameters

SECONDS = 10  # for another reader and one file
HEADER = {"points": 1, "samples": 2, "first": 3, "last": 4, "start": 8, "ratio": 9}
PARAMETERS = [("POINT", "USED"), ("POINT", "FRAMES"), ("POINT", "DATA_START"), ("ANALOG", "USED"), ("ANALOG", "RATE")]


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--files", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="folder for the files that nobody else reads so")
    arguments = parser.parse_args()
    rng, found = np.random.default_rng(arguments.seed), Counter()
    with tempfile.TemporaryDirectory() as name:
        for k in range(arguments.files):
            path = Path(name) / f"{k}.c3d"
            true, what = make(path, rng)
            outcome = judge(path, true)
            found[outcome] += 1
            if outcome == "ours alone" and arguments.keep:
                arguments.keep.mkdir(exist_ok=True, parents=True)
                (arguments.keep / path.name).write_bytes(path.read_bytes())
                print(k, what)
    for outcome, count in sorted(found.items()):
        print(f"{outcome:44} {count:6}")
    return 1 if found["ours alone"] else 0


def make(path: Path, rng: np.random.Generator) -> tuple[np.ndarray, str]:
    """A file with one or two wrong numbers; its points as they are, and what is wrong."""
    frames, points, channels, ratio = (int(rng.integers(low, high)) for low, high in ((3, 90), (1, 9), (0, 5), (1, 9)))
    places = rng.uniform(-900, 900, (1, points, 3)) + np.cumsum(rng.normal(0, 3, (frames, points, 3)), axis=0)
    file = fresh_layout(Recording(places, tuple(f"M{k}A" for k in range(points)), 100.0))
    true = np.asarray(file.points.view("<f4").reshape(frames, points, 4)[..., :3], float)
    samples = rng.normal(0, 1, (frames, channels * ratio)).astype("<f4")
    file.analog = samples.view(np.uint8).reshape(frames, -1)
    if rng.random() < 0.4:
        true = as_integers(file, samples)
    if channels:
        file.header = file.header[:18] + integers([ratio], 84) + file.header[20:]
        rate = Parameter("RATE", FLOAT, (), encode_floats([100.0 * ratio], 84))
        used = Parameter("USED", INT, (), integers([channels], 84))
        file.groups = with_parameters(file.groups, "ANALOG", [used, rate])
    write_layout(file, path)
    wrong = [change(path, rng) for _ in range(int(rng.integers(1, 3)))]
    return true, ", ".join(wrong)


def as_integers(file: C3dFile, samples: np.ndarray) -> np.ndarray:
    """Makes a file hold counts of a tenth of a millimetre, and gives its points."""
    records = file.points.view("<f4").reshape(*file.points.shape, 4)
    counts = np.round(records / 0.1).astype("<i2")
    counts[..., 3] = 0
    file.points = np.ascontiguousarray(counts).view("V8")[..., 0]
    file.analog = np.round(100 * samples).astype("<i2").view(np.uint8).reshape(len(samples), -1)
    scale = encode_floats([0.1], 84)
    file.header = file.header[:12] + scale + file.header[16:]
    file.groups = with_parameters(file.groups, "POINT", [Parameter("SCALE", FLOAT, (), scale)])
    return counts[..., :3] * float(np.float32(0.1))


def change(path: Path, rng: np.random.Generator) -> str:
    """Writes another number over one of the header's or the parameters', in place."""
    raw = bytearray(path.read_bytes())
    if rng.random() < 0.5:
        name = str(rng.choice(list(HEADER)))
        at = 2 * HEADER[name]
        old = int.from_bytes(raw[at : at + 2], "little")
        new = another(old, rng)
        raw[at : at + 2] = new.to_bytes(2, "little")
    else:
        group, name = PARAMETERS[int(rng.integers(len(PARAMETERS)))]
        begin = raw.find(name.encode(), raw.find(group.encode()))
        at = begin + len(name) + 4
        if begin < 0 or raw[at - 2] not in (INT, FLOAT):
            return "nothing"
        if raw[at - 2] == FLOAT:
            old, new = float(np.frombuffer(raw[at : at + 4], "<f4")[0]), 100.0 * int(rng.integers(1, 12))
            raw[at : at + 4] = encode_floats([new], 84)
        else:
            old = int.from_bytes(raw[at : at + 2], "little")
            new = another(old, rng)
            raw[at : at + 2] = new.to_bytes(2, "little")
        name = f"{group}:{name}"
    path.write_bytes(raw)
    return f"{name} {old} -> {new}"


def another(old: int, rng: np.random.Generator) -> int:
    choices = [old + 1, old - 1, old * 2, old // 2, 0, int(rng.integers(0, 200)), int(rng.integers(0, 1 << 16))]
    return int(choices[int(rng.integers(len(choices)))]) % (1 << 16)


def judge(path: Path, true: np.ndarray) -> str:
    """Who has the points that we read."""
    try:
        recording = io.read(path, drop=["!*"], frozen_gaps=False)
    except io.ReadError:
        return "refused"
    ours = np.nan_to_num(recording.points)
    if same(ours, true):
        return "read as it was written"
    if same(ours, true[: len(ours)]):
        return "read as it was written, but for its end"
    others = {"ezc3d": by_ezc3d, "c3d": by_c3d}
    agree = [name for name, reader in others.items() if same(ours, quietly(reader, path))]
    return f"as {' and '.join(agree)} read it" if agree else "ours alone"


def same(ours: np.ndarray, theirs: np.ndarray | None) -> bool:
    """Whether two readers have the same points; frames without any, at the end, are none."""
    if theirs is None or theirs.ndim != 3 or ours.shape[1:] != theirs.shape[1:]:
        return False
    frames = min(len(ours), len(theirs))
    alike = np.allclose(ours[:frames], theirs[:frames], rtol=1e-5, atol=1e-3)
    return alike and not ours[frames:].any() and not theirs[frames:].any()


def quietly(reader: Callable[[Path], np.ndarray], path: Path) -> np.ndarray | None:
    """What a reader gives, in a process of its own as some crash; nothing where it raises, crashes or hangs."""
    ours, theirs = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.get_context("fork").Process(target=_send, args=(reader, path, theirs))
    process.start()
    theirs.close()
    try:
        return ours.recv() if ours.poll(SECONDS) else None
    except EOFError:
        return None
    finally:
        process.kill()
        process.join()
        ours.close()


def _send(reader: Callable[[Path], np.ndarray], path: Path, pipe: Connection) -> None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pipe.send(reader(path))
    except Exception:  # whatever they raise
        pipe.send(None)


def by_ezc3d(path: Path) -> np.ndarray:
    import ezc3d

    file = ezc3d.c3d(str(path))
    seen = file["data"]["meta_points"]["residuals"][0].T[..., None] >= 0
    return np.nan_to_num(np.where(seen, file["data"]["points"][:3].transpose(2, 1, 0), 0.0))


def by_c3d(path: Path) -> np.ndarray:
    import c3d

    with path.open("rb") as handle:
        frames = [points for _, points, _ in c3d.Reader(handle).read_frames(copy=True)]
    table = np.array(frames, float)
    return np.nan_to_num(np.where(table[..., 3:4] >= 0, table[..., :3], 0.0))


if __name__ == "__main__":
    sys.exit(main())
