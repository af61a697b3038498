"""Segments of a model as people write them down, in TOML."""

import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

from dshpm_jax.io._errors import ReadError

_EXAMPLE = 'write it as [Pelvis] with markers = ["LASI", "RASI"] and, if it has one, parent = "Thorax"'


def read_segments(path: str | Path, known: Collection[str]) -> dict[str, dict[str, Any]]:
    """Reads `segment -> {"markers": [...], "parent": name or None}`.

    Arguments:
        known: the labels of the recordings; a segment may name no other.
    """
    path = Path(path)
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ReadError(path, f"cannot be read ({error.strerror})", "check the path") from None
    except (ValueError, RecursionError) as error:
        raise ReadError(path, f"is no TOML ({error})", _EXAMPLE) from None
    if not found:
        raise ReadError(path, "it names no segments", _EXAMPLE)
    return {name: _segment(path, name, value, found, known) for name, value in found.items()}


def _segment(path: Path, name: str, value: Any, segments: Collection[str], known: Collection[str]) -> dict[str, Any]:
    if not isinstance(value, dict) or not value.keys() <= {"markers", "parent"}:
        raise ReadError(path, f"the segment '{name}' holds something else than markers and a parent", _EXAMPLE)
    markers, parent = value.get("markers"), value.get("parent") or None
    if not isinstance(markers, list) or not markers or not all(isinstance(m, str) for m in markers):
        raise ReadError(path, f"the segment '{name}' has no list of markers", _EXAMPLE)
    if lost := [m for m in markers if m not in known]:
        wrong = f"the segment '{name}' names {', '.join(lost)}, which the recordings do not have"
        raise ReadError(path, wrong, f"use their labels: {', '.join(sorted(known))}")
    if parent is not None and (parent not in segments or parent == name):
        raise ReadError(path, f"the segment '{name}' has the parent '{parent}', which is no other segment", _EXAMPLE)
    return {"markers": markers, "parent": parent}
