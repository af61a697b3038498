"""What the trials gave, kept in a folder as they come, so that an experiment that was interrupted goes on."""

import csv
import io
import json
import os
import platform
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, cast

from dshpm_jax._experiments.trials import Point, TrialResult
from dshpm_jax._messages import UsageError
from dshpm_jax._settings import Method
from dshpm_jax.io._atomic import write_whole

LIBRARIES = ("dshpm-jax", "jax", "numpy")


class Records:
    """The outcomes of an experiment, in `FOLDER/NAME-trials.csv`.

    Arguments:
        folder: made if it is not there.
        name: of the experiment.
        setup: what the outcomes depend on. It is kept in `FOLDER/NAME.json`, with the machine.

    Raises:
        UsageError: the folder holds trials of another setup, or files of that name that are not ours.
    """

    def __init__(self, folder: Path, name: str, setup: Mapping[str, Any]):
        self._table, about = folder / f"{name}-trials.csv", folder / f"{name}.json"
        self._found: dict[Point, list[TrialResult]] = {}
        if folder.exists() and not folder.is_dir():
            raise UsageError(f"{folder}: is a file; give a folder for the results with -o")
        if self._table.exists() or about.exists():
            if _setup_in(about) != json.loads(json.dumps(setup)):
                raise UsageError(f"{folder}: holds trials of another setup of '{name}'; give another folder with -o")
            try:
                self._found = _read(self._table)
            except (ValueError, KeyError, TypeError):
                remedy = "move it away or give another folder with -o"
                raise UsageError(f"{self._table}: is damaged and cannot be gone on with; {remedy}") from None
        try:
            folder.mkdir(parents=True, exist_ok=True)
            write_text(about, json.dumps({"setup": setup, "machine": machine()}, indent=1) + "\n")
        except OSError as error:
            raise UsageError(f"{folder}: cannot be written ({error.strerror}); give another folder with -o") from None

    def of(self, point: Point) -> list[TrialResult]:
        """The outcomes of the first trials of a point."""
        return list(self._found.get(point, ()))

    def add(self, point: Point, outcomes: Iterable[TrialResult]) -> None:
        """Keeps the outcomes of the next trials of a point."""
        self._found[point] = [*self.of(point), *outcomes]
        rows = [(*point, k, *outcome) for point, found in self._found.items() for k, outcome in enumerate(found)]
        write_rows(self._table, (*Point._fields, "trial", *TrialResult._fields), rows)


def refuse_foreign(folder: Path, name: str, trials_of: str) -> None:
    """Raises `UsageError` where `folder` holds files called like results of `name`, but no trials that made them."""
    if (folder / f"{trials_of}-trials.csv").exists():
        return
    for suffix in (".csv", ".png", ".pdf"):
        if (path := folder / f"{name}{suffix}").exists():
            raise UsageError(f"{path}: is there without its trials, not overwritten; give another folder with -o")


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """A CSV file, whole or not at all; numbers are written so that they read back the same."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    write_text(path, text.getvalue())


def write_text(path: Path, text: str) -> None:
    write_whole(path, [text.encode(errors="backslashreplace")])


def machine() -> dict[str, Any]:
    """What the times were measured on."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        **{library: version(library) for library in LIBRARIES},
    }


def _processor() -> str:
    """The processor's name, as far as the system says it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _setup_in(about: Path) -> Any:
    try:
        return json.loads(about.read_text())["setup"]
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _read(table: Path) -> dict[Point, list[TrialResult]]:
    """The outcomes of a table of ours; none if it is not there yet."""
    found: dict[Point, list[TrialResult]] = {}
    if not table.exists():
        return found
    with table.open(newline="") as lines:
        for row in csv.DictReader(lines):
            point = Point(int(row["markers"]), row["kind"], float(row["level"]), cast(Method, row["method"]))
            values: dict[str, Any] = {f: kind(row[f]) for f, kind in TrialResult.__annotations__.items()}
            found.setdefault(point, []).append(TrialResult(**values))
    return found
