"""Damaged files through the whole command, dozens in a run: as recordings, as models, segments and settings."""

import contextlib
import io as streams
import json
import re
import shutil
from collections import Counter
from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path

from _fuzz_seeds import LEG, MODEL, TAKE

from dshpm_jax.__main__ import main as command
from dshpm_jax.io import SUBJECT_FILES

FILES = 40
"""Damaged recordings and models in a run."""

UNFORESEEN = re.compile(r"\b\w+(Error|Warning|Exception): ")
"""In a message, the sign of what no check foresaw."""


def runs_of(files: Sequence[Path]) -> list[tuple[Path | None, list[Path]]]:
    """What goes together into a run: damaged settings, or none, and other damaged files."""
    settings = [path for path in files if path.name.startswith("settings")]
    others = [path for path in files if path not in set(settings)]
    archives = [others[k : k + FILES] for k in range(0, len(others), FILES)]
    plain: list[tuple[Path | None, list[Path]]] = [(None, some) for some in archives[1::2]]
    return plain + [(which, some or []) for which, some in zip_longest(settings, archives[::2])]


def label_all(settings: Path | None, files: Sequence[Path], sound: Path, folder: Path) -> Counter[str]:
    """Labels an archive of damaged files and a sound one, and counts outcomes; raises where something is wrong.

    The sound recording is labelled as ever, each failed file has one line of its own and no result, each of the others
    has its result, and all of them have one row in the manifest.

    Arguments:
        sound: folder of the sound files.
        folder: for the archive and its results; must not be there.
    """
    captures, out, counts = folder / "captures", folder / "labelled", Counter[str]()
    captures.mkdir(parents=True)
    shutil.copy(sound / MODEL, captures / "model.json")
    shutil.copy(sound / TAKE, captures / "sound.c3d")
    for path in files:
        counts[f"{path.suffix} {_place(path, captures, sound)}"] += 1
    more = ["--settings", str(settings)] if settings else []
    status, lines = _said(["label", str(captures), "-o", str(out), *more])
    if settings:
        counts[f"settings, status {status}"] += 1
    if status == 2:
        _check(settings is not None and len(lines) == 1 and str(settings) in lines[0], lines)
        _check(not out.exists(), "a run that was refused has results")
        return counts
    rows = [json.loads(line) for line in (out / "manifest.jsonl").read_text().splitlines()]
    counts.update(f"{Path(row['input']).suffix} {row['outcome']}" for row in rows)
    _check_rows(rows, lines, captures, out)
    _check(status == (1 if any(row["outcome"] != "labelled" for row in rows) else 0), f"exit status {status}")
    first = next(row for row in rows if row["output"] == "sound.c3d")
    _check(settings is not None or first["outcome"] == "labelled", first)
    _check(settings is not None or first["labelled_points"] >= 0.9 * first["points"], first)
    return counts


def _place(path: Path, captures: Path, sound: Path) -> str:
    """Puts a damaged file into an archive, as a recording or as the model of a sound one."""
    if path.suffix not in (".json", ".toml", *SUBJECT_FILES):
        shutil.copy(path, captures)
        return "as a recording"
    place = captures / path.stem
    place.mkdir()
    if path.suffix == ".json":
        shutil.copy(path, place / "model.json")
    else:
        order = [str(sound / TAKE), "--segments", str(path)] if path.suffix == ".toml" else [str(path)]
        status, lines = _said(["model", *order, "-o", str(place / "model.json")])
        _check(status in (0, 1) and len(lines) == status, lines)
        _check((place / "model.json").exists() == (status == 0), "a model that failed is there")
        if status:
            return "makes no model"
    shutil.copy(sound / (LEG if path.suffix in SUBJECT_FILES else TAKE), place)
    return "as a model"


def _check_rows(rows: Sequence[dict], lines: Sequence[str], captures: Path, out: Path) -> None:
    inputs = [row["input"] for row in rows]
    found = sorted(str(path) for path in captures.rglob("*") if path.suffix in (".c3d", ".trc", ".csv", ".tsv"))
    _check(len(set(inputs)) == len(inputs) and set(inputs) <= set(found), "a file is twice in the manifest")
    known = {path for path in found if Path(path).suffix in (".c3d", ".trc")}  # others may be no recordings any more
    _check(known <= set(inputs), f"not in the manifest: {sorted(known - set(inputs))[:3]}")
    wanted = {"manifest.jsonl", "summary.csv", "report.html"}
    for row in rows:
        messages = [line for line in lines if line.removeprefix("dshpm-jax: ") == row.get("message")]
        _check(len(messages) == (row["outcome"] != "labelled"), (row, lines[:3]))
        if row["outcome"] != "labelled":
            _check(not UNFORESEEN.search(row["message"]) and len(row["message"]) < 1200, row["message"])
        if row["outcome"] not in ("failed", "passed over"):
            wanted |= {row["output"], *(str(Path(row["output"]).with_suffix(s)) for s in (".labels.json", ".html"))}
    there = {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}
    _check(there == wanted, f"other results than wanted: {sorted(there ^ wanted)[:5]}")
    messages = {row["message"] for row in rows if row["outcome"] != "labelled"}
    others = [line for line in (line.removeprefix("dshpm-jax: ") for line in lines) if line not in messages]
    _check(len(lines) == len(messages) + len(others), lines[-3:])
    strange = [line for line in others if not line.startswith(tuple(f"{path}: " for path in inputs))]
    _check(not strange, strange[:3])  # the rest are a reader's notes, each about its file


def _said(order: list[str]) -> tuple[int, list[str]]:
    """The exit status of a command, and its lines on standard error."""
    said, complained = streams.StringIO(), streams.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(complained):
        status = command(order)
    return status, complained.getvalue().splitlines()


def _check(good: bool, what: object) -> None:
    if not good:
        raise AssertionError(str(what))
