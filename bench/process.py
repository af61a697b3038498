"""How long does the whole `dshpm-jax label` process take over an archive, against ezc3d reading and rewriting it?

    python bench/process.py [--recordings 200] [--workers 2] [--quick]

The archive is that of `bench/archive.py`: worn recordings of 300 to 600 frames, five marker sets, 20 subjects. The
process starts afresh; the programs that it needs were compiled by one before it and are in the compile cache.
"""

import argparse
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import ezc3d
from _rows import Row, show
from _timing import paired, seconds
from archive import label_command, make


def rows(quick: bool, recordings: int = 200, workers: int = 2) -> Iterator[Row]:
    recordings = min(recordings, 10) if quick else recordings
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make(folder, recordings)
        files = sorted((folder / "captures").rglob("*.c3d"))
        case = f"{recordings} recordings, {workers} processes"
        yield Row(case, "first run, compiling included (s)", seconds(lambda: label(folder, workers)))
        times, ratios = paired([lambda: rewrite(files, folder), lambda: label(folder, workers)], 1 if quick else 3)
        frames = sum(ezc3d.c3d(str(path))["header"]["points"]["last_frame"] + 1 for path in files)
        yield Row(case, "process / ezc3d reads and writes", ratios[1], at_most=2.5)
        yield Row(case, "process (frames/s)", frames / times[1])
        yield Row(case, "ezc3d (frames/s)", frames / times[0])


def label(folder: Path, workers: int) -> None:
    """One run of the command, into a folder that goes away again."""
    out = folder / "labelled"
    environment = os.environ | {"DSHPM_CACHE": str(folder / "cache")}
    command = label_command(folder, out, "--workers", str(workers))
    done = subprocess.run(command, env=environment, stdout=subprocess.DEVNULL)
    if done.returncode not in (0, 1):  # 1: some file was not labelled completely
        raise SystemExit(f"{' '.join(command)} ended with {done.returncode}")
    shutil.rmtree(out)


def rewrite(files: list[Path], folder: Path) -> None:
    for path in files:
        ezc3d.c3d(str(path)).write(str(folder / "copy.c3d"))


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--recordings", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--quick", action="store_true", help="ten recordings, once")
    arguments = parser.parse_args()
    show(rows(arguments.quick, arguments.recordings, arguments.workers))


if __name__ == "__main__":
    main()
