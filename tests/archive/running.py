"""One run over a folder, and what is in the folder of results afterwards."""

import csv
import json
from pathlib import Path

from dshpm_jax._archive import Order, find_jobs, label_archive
from dshpm_jax._outcomes import WORST_FIRST
from dshpm_jax._settings import Settings

MARKERS = ["LASI", "RASI", "SACR"]


def run(archive, out, settings=None, **order):
    outcomes = list(label_archive(find_jobs([archive], (), out), Order(out, settings or Settings(), **order)))
    return {o.job.target.as_posix(): o for o in outcomes}


def contents(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def rows_of(out: Path) -> dict[str, dict]:
    """The manifest; each file has one row, there and in the summary, which has the worst first."""
    rows = [json.loads(line) for line in (out / "manifest.jsonl").read_text().splitlines()]
    with (out / "summary.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    worst_first = sorted(rows, key=lambda row: WORST_FIRST.index(row["outcome"]))
    assert [row["input"] for row in table] == [row["input"] for row in worst_first]
    assert len({row["input"] for row in rows}) == len(rows)
    return {row["output"] or row["input"]: row for row in rows}
