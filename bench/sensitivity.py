"""What each number of the full method decides: every one moved by 0.7 and by 1.4, the others left as they are.

    python bench/sensitivity.py WORK [--only REGEX] [--numbers REGEX] [--workers N] [--again]

WORK is the folder of an evaluation, as for `calibrate.py`. Its recordings are labelled with every number of `Tuning`
moved: whole numbers go to the next one, of a tuple all elements at once, switches are turned. Prints, for each move, F1
(mean and lowest), precision, rigid fits (median), and how many trajectories have another label than by default. Numbers
that move nothing come last: no label, no confidence, no fit depends on them here. Those that labelling with the
subject's own model does not use are left out.

Writes a row a move to `bench/results/sensitivity.csv` as soon as it is done. Rows that are there are skipped, as long
as recordings and numbers are those of before; else, or with `--again`, the file begins anew.
"""

import argparse
import csv
import multiprocessing
import re
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from _cases import Case, cases
from _moving import Outcome, figures, moves, moves_nothing, unmoved, with_number
from _truth import counts

from dshpm_jax import Labelling, label_many
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._control.tuning import TUNING, Tuning

RESULTS = Path(__file__).parent / "results" / "sensitivity.csv"
ELSEWHERE = "audit", "spikes", "population", "incremental"
"""Groups of numbers that labelling with the subject's own model does not use."""

AT_ONCE = 16  # recordings that are labelled side by side
HEADS: tuple[str, ...] = ("f1", "worst", "precision", "fits", "labels_changed", "confidences_changed", "fits_changed")
COLUMNS: tuple[str, ...] = ("number", "factor", "value", "recordings", *HEADS, "error")
DEFAULT = "default"

Row = dict[str, str]


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("work", type=Path)
    parser.add_argument("--only", default="", help="paths below WORK/archive that count, a regular expression")
    parser.add_argument("--numbers", default="", help="numbers that are moved, a regular expression")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--again", action="store_true", help="forget the rows that are there")
    parser.add_argument("-o", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    every = cases(arguments.work, arguments.only)
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(arguments.workers, spawn, initializer=begin, initargs=(every,)) as pool:
        default = pool.submit(measure, TUNING).result()
        usual = row(DEFAULT, 1.0, "", default, default)
        done = [] if arguments.again else read(arguments.o)
        if usual not in done:  # other recordings, or another method
            done = [usual]
            write(arguments.o, done)
        show(usual)
        todo = [m for m in moves(TUNING, ELSEWHERE) if re.search(arguments.numbers, m[0]) and not is_done(m, done)]
        for one in measured(pool, todo, default):
            append(arguments.o, one)
            show(one)
    summary([r for r in read(arguments.o) if r["number"] != DEFAULT])
    if fixed := unmoved(TUNING, ELSEWHERE):
        print(f"no factor moves {', '.join(fixed)}")


def measured(pool: ProcessPoolExecutor, todo: Sequence[tuple], default: Outcome) -> Iterator[Row]:
    """A row for each move, as it is done; one that fails says why."""
    waiting = {pool.submit(try_out, name, value): (name, factor, value) for name, factor, value in todo}
    for future in as_completed(waiting):
        outcome, error = future.result()
        yield row(*waiting[future], outcome, default, error)


_recordings: list[Any] = []
"""Of a worker: recordings, models and truths, read once."""


def begin(every: Sequence[Case]) -> None:
    """What a worker does first."""
    cache_programs()
    _recordings[:] = [case.read() for case in every]


def try_out(name: str, value: Any) -> tuple[Outcome | None, str]:
    """What labelling becomes with this value of a number, or why it cannot be."""
    try:
        return measure(with_number(TUNING, name, value)), ""
    except Exception as error:  # a number may be moved to where nothing works
        return None, " ".join(f"{type(error).__name__}: {error}".split())


def measure(tuning: Tuning) -> Outcome:
    """Labels a worker's recordings with these numbers."""
    outcome = Outcome([], [], [], [])
    for first in range(0, len(_recordings), AT_ONCE):
        recordings, models, truths = zip(*_recordings[first : first + AT_ONCE])
        for found, truth in zip(label_many(recordings, models, tuning=tuning), truths):
            points = counts(found, truth)
            outcome.f1.append(points.f1)
            outcome.precision.append(points.right / points.given if points.given else np.nan)
            outcome.fits.append(found.stats["svd_count"])
            outcome.labels.append(labels_of(found))
    return outcome


def labels_of(found: Labelling) -> dict[tuple[int, int], tuple[int, int, float]]:
    t = found.trajectories
    starts = zip(t.start.tolist(), t.column[t.start, t.slot].tolist())
    return dict(zip(starts, zip(t.stop.tolist(), found.identity.tolist(), found.confidence.tolist())))


def row(name: str, factor: float, value: Any, outcome: Outcome | None, default: Outcome, error: str = "") -> Row:
    """A row of the table, as text."""
    found: dict[str, Any] = figures(outcome, default) if outcome else dict.fromkeys(HEADS, "")
    cells = {"number": name, "factor": factor, "value": value, "recordings": len(default.f1), **found, "error": error}
    return {key: str(cells[key]) for key in COLUMNS}


def is_done(move: tuple[str, float, Any], done: Sequence[Row]) -> bool:
    return any((r["number"], r["factor"], r["value"]) == tuple(map(str, move)) for r in done)


def read(path: Path) -> list[Row]:
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write(path: Path, rows: Sequence[Row]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        table.writerows(rows)


def append(path: Path, one: Row) -> None:
    with path.open("a", newline="", encoding="utf-8") as file:
        csv.DictWriter(file, COLUMNS).writerow(one)


def show(one: Row) -> None:
    what = one["error"] or (
        f"F1 {one['f1']:>8}  worst {one['worst']:>8}  precision {one['precision']:>8}  fits {one['fits']:>8}  "
        f"changed: {one['labels_changed']:>4} labels {one['confidences_changed']:>5} confidences"
    )
    print(f"{one['number']:28} x {one['factor']:4} = {one['value'][:24]:24} {what}", flush=True)


def summary(rows: Sequence[Row]) -> None:
    """The numbers that move nothing."""
    each = groupby(sorted(rows, key=lambda r: r["number"]), lambda r: r["number"])
    idle = [name for name, some in each if moves_nothing(list(some))]
    print(f"{len(idle)} numbers move nothing: {', '.join(idle)}" if idle else "every number moves something")


if __name__ == "__main__":
    main()
