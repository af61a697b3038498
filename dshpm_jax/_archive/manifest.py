"""`manifest.jsonl` and `summary.csv`: a row for each file, whichever run it was labelled in."""

import csv
import json
import logging
import os
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from dshpm_jax._archive.jobs import SUMMARY_NAME
from dshpm_jax._archive.outcomes import Outcome
from dshpm_jax._messages import UsageError
from dshpm_jax._outcomes import FAILED, WORST_FIRST
from dshpm_jax.io._atomic import write_whole

MANIFEST_NAME = "manifest.jsonl"
SHARDS_NAME = "manifest-shards"

_ABOUT_THE_RUN = ("seconds", "finished")
_COLUMNS = (
    *("input", "output", "outcome", "completeness", "confidence", "model_fit", "message", "frames", "points"),
    *("labelled_points", "trajectories", "labelled_trajectories", "never_seen", "seconds", "finished"),
    *("models", "sha256", "model", "settings"),
)

_log = logging.getLogger(__name__)

Row = dict[str, Any]


class Manifest:
    """The rows of all runs into `out`; those of this run are appended as they come.

    Shards run side by side, maybe on several machines. Each appends to a file of its own, and whoever ends puts all of
    them together; the newest row of a file counts.

    Attributes:
        rows: what is known of each file, by its result; in that order once the manifest is closed.
    """

    def __init__(self, out: Path, shard: tuple[int, int] | None = None):
        """Raises `UsageError` where files of somebody else have the names of ours."""
        _check_ours(out)
        self._out = out
        self._journal = out / SHARDS_NAME / f"{shard[0]}-of-{shard[1]}.jsonl" if shard else out / MANIFEST_NAME
        self._journal.parent.mkdir(parents=True, exist_ok=True)
        with self._journal.open("a"):
            pass  # a folder that cannot be written shows before anything is labelled
        self._mine: dict[str, Row] = {}
        self.rows = known_rows(out)

    def add(self, outcome: Outcome) -> None:
        """Appends the row of `outcome`, unless it is up to date and its row is there."""
        row = _row(outcome)
        key = _key(row)
        resolved = key != row["input"] and row["input"] in self.rows  # the new row is to be the newer one
        if outcome.was_there and key in self.rows and not resolved and _lasting(row) == _lasting(self.rows[key]):
            return
        self.rows[key] = self._mine[key] = row
        try:
            with self._journal.open("a") as file:
                file.write(_text(row))
        except OSError:  # a full disk, say; it is tried again at the end
            _log.debug("%s cannot be written now", self._journal, exc_info=True)

    def close(self) -> None:
        """Writes the manifest with each file once, and the summary; raises `OSError` where that is not possible."""
        manifest = self._out / MANIFEST_NAME
        if self._journal != manifest:
            _write(self._journal, _newest([self._journal]) | self._mine)
        while True:
            shards = _contents(_shards(self._out))
            found = {**known_rows(self._out), **self._mine}
            current = _without_resolved(
                {key: row for key, row in found.items() if self._stands_for_something(row)}, self._out
            )
            self.rows = {key: current[key] for key in sorted(current)}
            _write(manifest, self.rows)
            write_whole(self._out / SUMMARY_NAME, [_summary(self.rows)])
            if _contents(_shards(self._out)) == shards:
                return  # else another shard ended at the same time, and it is not known who wrote last

    def _stands_for_something(self, row: Row) -> bool:
        """Whether the recording of `row` or its result is still there."""
        # Not Path.exists, which raises where a folder is closed.
        return os.path.exists(row["input"]) or bool(row["output"] and os.path.exists(self._out / row["output"]))


def known_rows(out: Path) -> dict[str, Row]:
    """The newest row of each file that any run into `out` has left."""
    return _newest([out / MANIFEST_NAME, *_shards(out)])


def _without_resolved(rows: Mapping[str, Row], out: Path) -> dict[str, Row]:
    """The rows without those of troubles that are over, and of results that are no more.

    A recording whose result was that of another has one of its own since then, or one in another format; or a folder
    that could not be searched, or held nothing, has recordings with a row.
    """
    newest: dict[str, str] = {}
    for row in rows.values():
        if row["output"]:
            newest[row["input"]] = max(row["finished"], newest.get(row["input"], ""))

    def is_resolved(row: Row) -> bool:
        source = row["input"]
        if row["outcome"] == FAILED and os.path.isdir(source):
            return os.access(source, os.R_OK | os.X_OK) and any(path.startswith(source + os.sep) for path in newest)
        later = newest.get(source, "")
        if row["output"]:
            return later > row["finished"] and not os.path.exists(out / row["output"])
        return later >= row["finished"]

    return {key: row for key, row in rows.items() if not is_resolved(row)}


def _shards(out: Path) -> list[Path]:
    return sorted((out / SHARDS_NAME).glob("*.jsonl"))


def _check_ours(out: Path) -> None:
    for name, beginning in ((MANIFEST_NAME, '{"input"'), (SUMMARY_NAME, ",".join(_COLUMNS[:3]))):
        path = out / name
        if path.is_file() and path.stat().st_size:
            with path.open("rb") as file:
                if not file.read(len(beginning)).startswith(beginning.encode()):
                    remedy = "move it away or give another folder for the results"
                    raise UsageError(f"{path}: is there and none of our files, not overwritten; {remedy}")


def _row(outcome: Outcome) -> Row:
    job = outcome.job
    return {
        "input": str(job.source.absolute()),
        "output": None if job.clashes else job.target.as_posix(),
        "models": [str(path.absolute()) for path in job.models],
        "outcome": outcome.outcome,
        **({"message": outcome.message} if outcome.message else {}),
        **outcome.hashes,
        **outcome.figures,
        **({"doubts": list(outcome.doubts)} if outcome.figures else {}),
        **({} if outcome.seconds is None else {"seconds": outcome.seconds}),
        "finished": datetime.now(UTC).isoformat(),
    }


def _key(row: Row) -> str:
    """One for each result; of two recordings whose results clash, one has none."""
    return row["output"] or row["input"]


def _lasting(row: Row) -> Row:
    return json.loads(_text({name: value for name, value in row.items() if name not in _ABOUT_THE_RUN}))


def _newest(paths: Iterable[Path]) -> dict[str, Row]:
    """The newest row of each file; lines that a killed run left unfinished are passed over."""
    rows: dict[str, Row] = {}
    for path, text in _contents(paths).items():
        for line in text.splitlines():
            try:
                row = json.loads(line)
                known = rows.get(_key(row))
                if known is None or row["finished"] >= known["finished"]:
                    rows[_key(row)] = row
            except (ValueError, TypeError, KeyError):
                _log.debug("%s holds a line that is no row: %s", path, line)
    return rows


def _contents(paths: Iterable[Path]) -> dict[Path, str]:
    return {path: path.read_text(encoding="utf-8", errors="replace") for path in paths if path.exists()}


def _write(path: Path, rows: Mapping[str, Row]) -> None:
    write_whole(path, [_text(row).encode() for row in rows.values()])


def _text(row: Row) -> str:
    return json.dumps(row, default=_plain) + "\n"


def _summary(rows: Mapping[str, Row]) -> bytes:
    """The table, what needs somebody first; in it names that are several stand in one cell."""
    worst_first = sorted(rows.values(), key=_severity)
    table = StringIO(newline="")
    writer = csv.DictWriter(table, _COLUMNS, extrasaction="ignore")
    writer.writeheader()
    lists = ("models", "never_seen")
    writer.writerows({**row, **{name: " ".join(row.get(name, ())) for name in lists}} for row in worst_first)
    return table.getvalue().encode(errors="backslashreplace")  # names of files may be no text


def _severity(row: Row) -> int:
    """The place of its outcome; the place of one that a later version may have written is the last."""
    return WORST_FIRST.index(row["outcome"]) if row["outcome"] in WORST_FIRST else len(WORST_FIRST)


def _plain(value: Any) -> Any:
    """Numpy values, which json does not know."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)
