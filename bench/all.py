"""Runs the benches of speed and keeps what they found: a table, plots, and what they ran on.

    python bench/all.py [--quick] [--only BENCH ...] [--out bench/results]

Each bench runs in a process of its own, whose peak memory is a row too. `speed.csv` and `speed.json` hold the figures
beside their aims and the machine, `speed-aims` how far each figure is from its aim, and `speed-scaling` the curves.
With --only, rows of the other benches stay as the last run left them.
"""

import argparse
import csv
import json
import os
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from itertools import groupby
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from _machine import description, peak_memory
from _rows import Row, show

from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._experiments.figures import PANEL, panels, save, style

BENCHES = (
    *("rigid_fit", "matching", "tracking", "life_costs", "startup"),
    *("speed", "scaling", "process", "live", "devices"),
)
COUNT_NO_COMPILING = ("speed", "scaling", "live", "devices")  # these may share compiled programs
NAME = "speed"  # of the files with results


class Found(NamedTuple):
    """A row and the bench that it is of."""

    bench: str
    row: Row


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer and smaller cases, fewer runs: some minutes")
    parser.add_argument("--only", nargs="+", choices=BENCHES, default=BENCHES, metavar="BENCH", help=", ".join(BENCHES))
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    machine = description() | {"quick": arguments.quick}
    found = kept(arguments.out, arguments.only)
    with TemporaryDirectory() as cache:
        os.environ.setdefault("DSHPM_CACHE", cache)
        for bench in arguments.only:
            print(f"{bench}:", flush=True)
            found += [Found(bench, row) for row in run_alone(bench, arguments.quick)]
    found.sort(key=lambda one: BENCHES.index(one.bench))
    arguments.out.mkdir(parents=True, exist_ok=True)
    write(found, machine, arguments.out)
    with style():
        draw_aims(found, arguments.out)
        draw_scaling(found, arguments.out)


def run_alone(bench: str, quick: bool) -> list[Row]:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
        return process.submit(measure, bench, quick).result()


def measure(bench: str, quick: bool) -> list[Row]:
    """The rows of a bench, and what it took itself; runs in the bench's process."""
    begin, found = time.perf_counter(), []
    if bench in COUNT_NO_COMPILING:
        cache_programs()
    for row in import_module(bench).rows(quick):
        show([row])
        found.append(row)
    found.append(Row("the bench itself", "peak memory (GB)", peak_memory() / 1e9))
    found.append(Row("the bench itself", "took (s)", time.perf_counter() - begin))
    show(found[-2:])
    return found


def kept(out: Path, again: Sequence[str]) -> list[Found]:
    """What an earlier run found with the benches that do not run again."""
    path = out / f"{NAME}.json"
    rows = json.loads(path.read_text())["rows"] if path.exists() else []
    return [Found(row.pop("bench"), Row(**row)) for row in rows if row["bench"] not in again]


def write(found: Sequence[Found], machine: dict, out: Path) -> None:
    with (out / f"{NAME}.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("bench", "case", "figure", "value", "aim", "met"))
        for bench, row in found:
            table.writerow((bench, row.case, row.figure, f"{row.value:.4g}", row.aim, row.met))
    whole = {"machine": machine, "rows": [{"bench": one.bench, **one.row._asdict()} for one in found]}
    (out / f"{NAME}.json").write_text(json.dumps(whole, indent=1) + "\n")


def draw_aims(found: Sequence[Found], out: Path) -> None:
    """How many times better than its aim each figure is."""
    judged = [(one, better(one.row)) for one in found if one.row.aim and one.row.value > 0]
    if not judged:
        return
    figure, (axes,) = panels(1, (2 * PANEL[0], 0.8 + 0.17 * len(judged)))
    names = [f"{one.bench}: {one.row.figure}, {one.row.case}" for one, _ in judged]
    axes.barh(names, [times - 1 for _, times in judged], left=1, color=[COLOUR[times >= 1] for _, times in judged])
    axes.axvline(1, color="black")
    axes.set_xscale("log")
    axes.invert_yaxis()
    axes.tick_params(axis="y", labelsize=6)
    axes.set_xlabel("times better than the aim")
    save(figure, out / f"{NAME}-aims")


COLOUR = {True: "#009e73", False: "#d55e00"}  # met, missed


def better(row: Row) -> float:
    """How many times better than its aim a figure is; under 1 it misses it."""
    return row.value / row.at_least if row.at_least is not None else (row.at_most or 0) / row.value


def draw_scaling(found: Sequence[Found], out: Path) -> None:
    """A panel for each growth: seconds against size, on logarithmic axes."""
    sized = [one.row for one in found if one.row.size is not None]
    curves = {figure: list(rows) for figure, rows in groupby(sized, key=lambda row: row.figure)}
    if not curves:
        return
    figure, all_axes = panels(len(curves))
    for axes, (name, rows) in zip(all_axes, curves.items()):
        axes.plot([row.size for row in rows], [row.value for row in rows], "o-")
        axes.set(xscale="log", yscale="log", xlabel=name.removeprefix("time against ").removesuffix(" (s)"))
        axes.set_xticks([row.size for row in rows], [f"{row.size:g}" for row in rows])
        axes.set_xticks([], minor=True)
    all_axes[0].set_ylabel("seconds")
    save(figure, out / f"{NAME}-scaling")


if __name__ == "__main__":
    main()
