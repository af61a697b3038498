"""What happens to damaged files?

    python bench/fuzz.py [--files 20000] [--labelled 0.1] [--seed 0] [--keep FOLDER]

Damages small sound files of every format that is read: their bytes (cut short, bits turned over, fields at their
extremes, bytes, numbers and lines exchanged, repeated and left out), and of most models, settings and segments the
values alone, so that they stay JSON and TOML. Each file must give a recording, a model, segments or settings, or raise
one line that names the file, in under `SECONDS` of a processor and in an address space of `MEMORY`.

A share `--labelled` of those that are read, thrice that of the models, settings and segments, and a tenth of it of what
cannot be read, go through the whole command, dozens in a run: recordings are labelled with a sound model, sound
recordings with the models, settings and segments. Each run must come to its end, with a line for each file that failed
and no result of it, and label the sound recording among them as ever. What does harm is kept in FOLDER, and the exit
status is 1.
"""

import argparse
import contextlib
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from _fuzz_bytes import damage_bytes
from _fuzz_runs import label_all, runs_of
from _fuzz_seeds import KNOWN, write_seeds
from _fuzz_values import damage_values

from dshpm_jax import Settings
from dshpm_jax.io import SUBJECT_FILES, ReadError, first_frame, read, read_model, read_segments

SECONDS, MEMORY = 10, 2 << 30
VALUES_SHARE = 0.7
"""Of the models, settings and segments, how many have their values damaged rather than their bytes."""

SHARES, REFUSED = (1.0, 3.0), 0.1
"""Factors on the share that is labelled: of recordings and subject files, of models, settings and segments, and of what
cannot be read."""


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--files", type=int, default=20_000)
    parser.add_argument("--labelled", type=float, default=0.1, help="share of what is read that is labelled too")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="folder for the files that did harm")
    arguments = parser.parse_args()
    start, judge = time.perf_counter(), Judge(arguments.keep)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "sound").mkdir()
        seeds = write_seeds(folder / "sound")
        chosen = _read_all(seeds, folder, judge, arguments)
        runs = runs_of(chosen)
        for k, (settings, files) in enumerate(runs):
            place = folder / f"run {k}"
            with judge.of(place, 2 * SECONDS * (len(files) + 1)):
                judge.outcomes += label_all(settings, files, folder / "sound", place)
            shutil.rmtree(place)
    for what, count in sorted(judge.outcomes.items()):
        print(f"{what:34} {count:7}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"{arguments.files} read, {len(chosen)} through the command in {len(runs)} runs, seed {arguments.seed}")
    print(f"{time.process_time():.0f} s of a processor, {time.perf_counter() - start:.0f} s, peak {peak:.2f} GB")
    print(f"{len(judge.bad)} did harm")
    return 1 if judge.bad else 0


def _read_all(seeds: list[Path], folder: Path, judge: "Judge", arguments: argparse.Namespace) -> list[Path]:
    """Reads every damaged file, and leaves those that are to be labelled."""
    limits = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, limits[1]))
    chosen = []
    for k in range(arguments.files):
        path = _damaged(seeds, folder, arguments.seed, k)
        share, drawn = 0.0, np.random.default_rng([arguments.seed, k, 1]).random()
        with judge.of(path, SECONDS):
            outcome = _read(path)
            judge.outcomes[f"{path.suffix} {outcome}"] += 1
            share = arguments.labelled * (SHARES[path.suffix in (".json", ".toml")] if outcome == "read" else REFUSED)
        if drawn < share:
            chosen.append(path)
        else:
            path.unlink()
    resource.setrlimit(resource.RLIMIT_AS, limits)  # compiled programs reserve more than they use
    return chosen


class Judge:
    """Counts what becomes of files; what is raised about one is harm."""

    def __init__(self, keep: Path | None):
        self.outcomes: Counter[str] = Counter()
        self.bad: list[str] = []
        self._keep = keep

    @contextlib.contextmanager
    def of(self, path: Path, seconds: int):
        """Judges a damaged file, or a folder of them, which may take so many seconds of a processor."""
        try:
            with _within(seconds), warnings.catch_warnings():
                warnings.simplefilter("error")
                yield
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            where = f"({Path(place.filename).name}:{place.lineno})"
            self.bad.append(f"{path.name}: {type(error).__name__}: {str(error)[:400]!r} {where}")
            self.outcomes[f"{path.suffix or 'run'} did harm"] += 1
            print(self.bad[-1], flush=True)
            if self._keep:
                self._keep.mkdir(parents=True, exist_ok=True)
                copy = shutil.copytree if path.is_dir() else shutil.copy
                copy(path, self._keep / path.name)


@contextlib.contextmanager
def _within(seconds: int):
    def late(*_):
        raise TimeoutError(f"more than {seconds} s of a processor")

    signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def _read(path: Path) -> str:
    """Whether a file is read or refused; raises where it is neither."""
    try:
        _reader(path)(path)
    except ReadError as error:
        _check_line(str(error), path)
        return "refused"
    except ValueError as error:
        if path.name.startswith("settings") and type(error) is ValueError:
            _check_line(str(error), path)
            return "refused"
        raise
    return "read"


def _reader(path: Path) -> Callable[[Path], object]:
    if path.suffix == ".toml":
        return Settings.from_toml if path.name.startswith("settings") else lambda p: read_segments(p, KNOWN)
    if path.suffix == ".json" or path.suffix in SUBJECT_FILES:
        return read_model
    return lambda p: (first_frame(p), read(p))


def _check_line(text: str, path: Path) -> None:
    if not text.startswith(f"{path}: ") or len(text.splitlines()) != 1 or len(text) > len(str(path)) + 600:
        raise AssertionError(f"no clear line: {text[:200]!r}")


def _damaged(seeds: list[Path], folder: Path, seed: int, k: int) -> Path:
    """The k-th damaged file; the same for the same seed, whatever came before."""
    rng = np.random.default_rng([seed, k])
    often = [seed for seed in seeds if seed.suffix in (".json", ".toml")] * 2
    source = (seeds + often)[int(rng.integers(len(seeds + often)))]
    data = source.read_bytes()
    if source.suffix in (".json", ".toml") and rng.random() < VALUES_SHARE:
        data = damage_values(data, source.suffix, rng)
    else:
        data = damage_bytes(data, source.suffix != ".c3d", rng)
    path = folder / f"{source.stem}-{k}{source.suffix}"
    path.write_bytes(data)
    return path


if __name__ == "__main__":
    sys.exit(main())
