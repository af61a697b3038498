"""The lines of a file of corrections: what each holds, and how it is written and read."""

import json
import uuid
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any, Literal, get_args

from dshpm_jax._known import KnownLabel

FORMAT = "dshpm-corrections"
VERSION = 1

Kind = Literal["label", "confirm", "cut", "fill", "undo", "redo"]


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


@dataclass(frozen=True)
class Change:
    """The label that some points get: a column of the source file, over a span of frames.

    Attributes:
        column: of the source file, from 0.
        first, last: the span, frames `first <= t < last`, from 0.
        label: the marker's name as the result calls it, or None for no marker.
        was: the label that most of the points had before, if any.
    """

    column: int
    first: int
    last: int
    label: str | None
    was: str | None = None

    @property
    def known(self) -> KnownLabel:
        return KnownLabel(self.column, self.first, self.last, self.label)


@dataclass(frozen=True)
class Correction:
    """One thing that a person did; a line of the file. All its changes count together or not at all.

    Attributes:
        kind: "label" (the changes are made), "confirm" (the labels of the changes are right as they are), "cut" (a
            trajectory is cut, and nothing said of its parts), "fill" (a filled gap is accepted, or refused again),
            "undo" or "redo" (of the correction `of`).
        changes: what labels which points get; an exchange has two, one over several trajectories more.
        whole: with "confirm": whether the whole result is confirmed, besides the labels of the changes.
        of: the id of the correction that is undone or redone.
        details: what the page of `review` keeps with it, such as the labels before and after; nothing else reads them.
        by: the name of the person, if it is known.
        id, time: which correction it is, and when it was made (ISO 8601, UTC).
    """

    kind: Kind
    changes: tuple[Change, ...] = ()
    whole: bool = False
    of: str | None = None
    details: Mapping[str, Any] = field(default_factory=dict)
    by: str | None = None
    id: str = field(default_factory=lambda: uuid.uuid4().hex)
    time: str = field(default_factory=_now)


def head_line(recording: str, points: str) -> bytes:
    """The first line: which recording the corrections are of, by the name of its file and the hash of its points."""
    return _line({"format": FORMAT, "version": VERSION, "recording": recording, "points": points})


def correction_line(correction: Correction) -> bytes:
    found: dict[str, Any] = {"id": correction.id, "time": correction.time, "kind": correction.kind}
    found |= {"by": correction.by} if correction.by is not None else {}
    found |= {"of": correction.of} if correction.of is not None else {}
    found |= {"whole": True} if correction.whole else {}
    found |= {"changes": [vars(change) for change in correction.changes]} if correction.changes else {}
    found |= {"details": dict(correction.details)} if correction.details else {}
    return _line(found)


def _line(content: dict[str, Any]) -> bytes:
    return json.dumps(content).encode() + b"\n"


def head_of(line: bytes) -> tuple[str, str]:
    """The recording's name and the hash of its points; `ValueError` where the line is no head."""
    content = json.loads(line)
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ValueError("is none of our files of corrections")
    if content.get("version") != VERSION:
        raise ValueError(f"is of version {content.get('version')}, and this program knows {VERSION}")
    return _text(content["recording"]), _text(content["points"])


def correction_of(line: bytes) -> Correction:
    """The correction of a line; `ValueError`, `KeyError` or `TypeError` where it holds none."""
    content = json.loads(line)
    if content["kind"] not in get_args(Kind):
        raise ValueError(f"unknown kind of correction {content['kind']!r}")
    changes = tuple(_change(Change(**change)) for change in content.get("changes", ()))
    whole, names = content.get("whole", False), {name: content.get(name) for name in ("of", "by")}
    details = content.get("details", {})
    if not isinstance(details, dict):
        raise ValueError("its details have no names")
    made = {"id": _text(content["id"]), "time": _text(content["time"])}
    return Correction(content["kind"], changes, whole, **names, details=details, **made)


def _change(change: Change) -> Change:
    numbers, names = (change.column, change.first, change.last), (change.label, change.was)
    if not all(isinstance(n, int) for n in numbers) or not all(isinstance(n, str | None) for n in names):
        raise ValueError("a change holds no numbers or names")
    assert change.known  # which refuses spans that cannot be
    return change


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{value!r} is no text")
    return value


def resolved(corrections: Iterable[Correction]) -> tuple[list[Correction], list[Correction]]:
    """The corrections that stand, in the order they were made, and those that can be redone, the last undone last.

    A new correction leaves nothing to redo.
    """
    made: dict[str, Correction] = {}
    undone: dict[str, Correction] = {}
    for one in corrections:
        if one.kind == "undo" and one.of in made and one.of not in undone:
            undone[one.of] = made[one.of]
        elif one.kind == "redo":
            undone.pop(one.of or "", None)
        elif one.kind not in ("undo", "redo"):
            for gone in undone:
                del made[gone]
            made[one.id], undone = one, {}
    return [one for one in made.values() if one.id not in undone], list(undone.values())
