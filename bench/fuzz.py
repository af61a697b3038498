"""What happens to damaged files?

    python bench/fuzz.py [--files 20000] [--whole 100] [--seed 0] [--keep FOLDER]

Damages small sound files of every format that is read (cut short, bits turned over, fields at their extremes, bytes,
numbers and lines exchanged, repeated and left out) and reads them. Each must give a recording, a model, segments or
settings, or raise one line that names the file, in under `SECONDS` of a processor and in an address space of `MEMORY`.
`--whole` of them also go through the whole command, as a recording, a model or settings: it must end with an exit
status of its own, one line for the file and no output for one that failed. What does not is kept in FOLDER, and the
exit status is 1.
"""

import argparse
import contextlib
import io as streams
import resource
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
from _fuzz_seeds import KNOWN, write_seeds

from dshpm_jax import Settings
from dshpm_jax.io import SUBJECT_FILES, ReadError, first_frame, read, read_model, read_segments

SECONDS, MEMORY = 10, 2 << 30
EXTREMES = (0, 1, 2, 0x50, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
FLOATS = (0.0, -1.0, 1e-38, 1e38, -1e38, np.inf, -np.inf, np.nan)
NUMBERS = ("", "0", "-1", "nan", "inf", "1e308", "-1e308", "1e-308", "99999999999999999999", "1,5", "0x10", "\u0663")
WORDS = (*NUMBERS, "true", "null", "{}", "[]", '"', "'", "<", "&a;", "\0", "\u2028", "a" * 5000)
NESTED = 20_000


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--files", type=int, default=20_000)
    parser.add_argument("--whole", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="folder for the files that did harm")
    arguments = parser.parse_args()
    start, outcomes, bad = time.perf_counter(), Counter(), []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "seeds").mkdir()
        seeds = write_seeds(folder / "seeds")
        limits = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, limits[1]))
        for k in range(arguments.files):
            path = _damaged(seeds, folder, arguments.seed, k)
            _judge(lambda path=path: _read(path), path, outcomes, bad, arguments.keep, k)
        resource.setrlimit(resource.RLIMIT_AS, limits)  # compiled programs reserve more than they use
        for k in range(arguments.whole):
            path = _damaged(seeds, folder, arguments.seed, arguments.files + k)
            _judge(
                lambda path=path: _command(path, seeds, folder), path, outcomes, bad, arguments.keep, k, 60 * SECONDS
            )
    for what, count in sorted(outcomes.items()):
        print(f"{what:34} {count:7}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"{arguments.files} read, {arguments.whole} through the command, seed {arguments.seed}: {len(bad)} did harm; "
          f"{time.perf_counter() - start:.0f} s, peak memory {peak:.2f} GB")  # fmt: skip
    for line in bad[:20]:
        print(line)
    return 1 if bad else 0


def _judge(
    check: Callable[[], str], path: Path, outcomes: Counter, bad: list, keep: Path | None, k: int, seconds=SECONDS
):
    """Counts what `check` says; what it raises is harm."""
    try:
        with _within(seconds), warnings.catch_warnings():
            warnings.simplefilter("error")
            outcomes[f"{path.suffix} {check()}"] += 1
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        place = traceback.extract_tb(error.__traceback__)[-1]
        bad.append(
            f"{path.name}: {type(error).__name__}: {str(error)[:150]!r} ({Path(place.filename).name}:{place.lineno})"
        )
        outcomes[f"{path.suffix} did harm"] += 1
        if keep:
            keep.mkdir(parents=True, exist_ok=True)
            (keep / f"{k}-{path.name}").write_bytes(path.read_bytes())
    finally:
        path.unlink(missing_ok=True)


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


def _command(path: Path, seeds: list[Path], folder: Path) -> str:
    """The whole command with the damaged file in its place."""
    from dshpm_jax.__main__ import main as command

    by_name = {seed.name: seed for seed in seeds}
    recording, model, more = by_name["plain.c3d"], by_name["subject.json"], []
    if path.suffix == ".toml":
        more = ["--settings", str(path)] if path.name.startswith("settings") else []
    elif path.suffix == ".json" or path.suffix in SUBJECT_FILES:
        model = path
    else:
        recording = path
    out = Path(tempfile.mkdtemp(dir=folder))
    said, complained = streams.StringIO(), streams.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(complained):
        status = command(["label", str(recording), "--model", str(model), "-o", str(out), *more])
    lines = complained.getvalue().splitlines()
    if status not in (0, 1, 2) or "Traceback" in complained.getvalue() or (status and len(lines) != 1):
        raise AssertionError(f"exit status {status}, {lines[:3]}")
    if status and "only" not in lines[0] and list(out.glob("*.c3d")):
        raise AssertionError(f"{lines[0]}, and yet there is a result")
    return f"through the command, status {status}"


def _damaged(seeds: list[Path], folder: Path, seed: int, k: int) -> Path:
    """The k-th damaged file; the same for the same seed, whatever came before."""
    rng = np.random.default_rng([seed, k])
    source = seeds[int(rng.integers(len(seeds)))]
    data = source.read_bytes()
    for _ in range(int(rng.integers(1, 4))):
        ways = BINARY if source.suffix == ".c3d" else BINARY[:4] + TEXT
        data = ways[int(rng.integers(len(ways)))](data, rng)
    path = folder / f"{source.stem}-{k}{source.suffix}"
    path.write_bytes(data)
    return path


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: int(rng.integers(len(data) + 1))]


def _flip(data: bytes, rng: np.random.Generator) -> bytes:
    broken = bytearray(data)
    for at in rng.integers(0, max(len(data), 1), int(2 ** rng.integers(0, 8))) if data else ():
        broken[at] ^= 1 << int(rng.integers(8))
    return bytes(broken)


def _exchange(data: bytes, rng: np.random.Generator) -> bytes:
    a, b, c, d = np.sort(rng.integers(0, len(data) + 1, 4)).tolist()
    return data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:]


def _repeat(data: bytes, rng: np.random.Generator) -> bytes:
    a, b = np.sort(rng.integers(0, len(data) + 1, 2)).tolist()
    return (
        data[:b] + data[a:b][:50_000] * int(rng.integers(1, 4)) + data[b:]
        if rng.random() < 0.5
        else data[:a] + data[b:]
    )


def _field(data: bytes, rng: np.random.Generator) -> bytes:
    """A field of the header or the parameters at an extreme."""
    size, order = int(2 ** rng.integers(0, 3)), "little" if rng.random() < 0.7 else "big"
    at = int(rng.integers(0, 24 if rng.random() < 0.5 else 2048))
    value = int(rng.choice(EXTREMES)) % (1 << 8 * size)
    return data[:at] + value.to_bytes(size, order) + data[at + size :]


def _float(data: bytes, rng: np.random.Generator) -> bytes:
    at = 4 * int(rng.integers(0, max(1, len(data) // 4)))
    return data[:at] + np.float32(rng.choice(FLOATS)).tobytes() + data[at + 4 :]


def _lines(data: bytes, rng: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    a, b = (int(k) for k in rng.integers(0, len(lines), 2))
    kind = int(rng.integers(3))
    if kind == 0:
        lines[a], lines[b] = lines[b], lines[a]
    elif kind == 1:
        del lines[min(a, b) : max(a, b)]
    else:
        lines.insert(a, lines[b])
    return b"\n".join(lines)


def _word(data: bytes, rng: np.random.Generator) -> bytes:
    """A cell, number or name as something else."""
    ends = [k for k, byte in enumerate(data) if byte in b' \t\n,;:="<>[]{}']
    if len(ends) < 2:
        return data
    k = int(rng.integers(len(ends) - 1))
    return data[: ends[k] + 1] + str(rng.choice(WORDS)).encode() + data[ends[k + 1] :]


def _nest(data: bytes, rng: np.random.Generator) -> bytes:
    """Brackets or elements within each other, thousands deep."""
    at = int(rng.integers(len(data) + 1))
    return data[:at] + (b"[", b"{", b'{"a":', b"<Segment>", b"<objects>")[int(rng.integers(5))] * NESTED + data[at:]


def _entity(data: bytes, rng: np.random.Generator) -> bytes:
    bomb = b'<!DOCTYPE a [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    at = data.find(b"?>") + 2 if rng.random() < 0.8 else 0
    return data[:at] + bomb + data[at:]


BINARY = (_cut, _flip, _exchange, _repeat, _field, _float, _field)
TEXT = (_lines, _lines, _word, _word, _word, _nest, _entity)

if __name__ == "__main__":
    sys.exit(main())
