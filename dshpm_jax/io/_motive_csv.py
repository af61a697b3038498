"""CSV files of Motive (OptiTrack): a line of keys and values, rows of what each column is, then the frames."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._numbers import one_number
from dshpm_jax.io._text_table import TextLines, TextTable, end_of_rows, join, split
from dshpm_jax.io._units import length_unit

_REMEDY = "export it again with its markers"
_MARKERS = ("marker", "rigid body marker", "bone marker")
"""Kinds of columns that hold markers, the measured ones first; of the others, only computed positions are known."""


@dataclass(frozen=True)
class MotiveTable(TextTable):
    """A Motive export. `kind_at`, `name_at` and `axes_at` are the lines of kinds, of names and of the axes."""

    kind_at: int = 0
    name_at: int = 0
    axes_at: int = 0

    def file_width(self) -> int:
        return len(split(self.file.lines[self.axes_at], self.delimiter))

    def head(self, names: Sequence[str], origins: Sequence[int | None], order: Sequence[int | None]) -> Iterator[str]:
        yield from self.file.lines[: self.kind_at]
        renamed = self._beside_points(names, origins)
        for row in range(self.kind_at, self.axes_at + 1):
            old = split(self.file.lines[row], self.delimiter)
            if row == self.name_at:
                old = [renamed.get(c, cell) for c, cell in enumerate(old)]
            new = iter([cell for k, name in enumerate(names) for cell in self._over_point(row, old, name, origins[k])])
            cells = [(old[c] if c < len(old) else "") if c is not None else next(new) for c in order]
            yield join(cells, self.delimiter) if old else ""

    def _beside_points(self, names: Sequence[str], origins: Sequence[int | None]) -> dict[int, str]:
        """The names over other columns of points, such as sizes: those that their points have now, if they have one."""
        rows = [split(line, self.delimiter) for line in self.file.lines[self.kind_at : self.axes_at - 1]]
        above = list(zip(*([*row, *[""] * (self.file_width() - len(row))] for row in rows if any(row))))
        now = dict(zip(origins, names))
        named = {above[first]: now.get(point, "") for point, first in enumerate(self.columns)}
        coordinates = {first + k for first in self.columns for k in range(3)}
        return {c: named[key] for c, key in enumerate(above) if c not in coordinates and key in named}

    def _over_point(self, row: int, old: Sequence[str], name: str, origin: int | None) -> list[str]:
        """What stands over a point's three columns: its name, what every point has, or its own ID and parent."""
        first = self.columns[0] if origin is None else self.columns[origin]
        cells = [old[c] if c < len(old) else "" for c in range(first, first + 3)]
        if row == self.name_at:
            return [name] * 3
        shared = row == self.kind_at or row >= self.axes_at - 1
        return cells if shared or origin is not None else [""] * 3


def is_motive(file: TextLines) -> bool:
    return file.lines[0].lstrip(' "').lower().startswith("format version")


def motive_table(file: TextLines) -> MotiveTable:
    """The markers of a Motive export."""
    delimiter = max(",;\t", key=file.lines[0].count)
    values = _values(split(file.lines[0], delimiter))
    axes_at = next((k for k, line in enumerate(file.lines) if _is_axes(line, delimiter)), None)
    top = next((k for k, line in enumerate(file.lines[1:], 1) if line.strip(" \t,;")), None)
    if axes_at is None or top is None or axes_at - top < 3:
        raise ReadError(file.path, "it has no rows of kinds, names and axes above its frames", _REMEDY)
    kinds, names, parts, axes = (split(file.lines[row], delimiter) for row in (top, top + 1, axes_at - 1, axes_at))
    columns = _columns(kinds, parts, axes)
    return MotiveTable(
        file,
        (axes_at + 1, max(axes_at + 1, end_of_rows(file.lines))),
        delimiter,
        tuple(names[c] if c < len(names) else "" for c in columns),
        tuple(columns),
        _number(values, ("export frame rate", "capture frame rate"), file),
        length_unit(values.get("length units", ""), file.path),
        _number(values, ("total exported frames",), file) if values.get("total exported frames") else None,
        kind_at=top,
        name_at=top + 1,
        axes_at=axes_at,
    )


def _is_axes(line: str, delimiter: str) -> bool:
    """Whether a line names the columns."""
    return split(line, delimiter)[0].lower() == "frame" if delimiter in line else False


def _values(cells: Sequence[str]) -> dict[str, str]:
    return {key.lower(): value for key, value in zip(cells[::2], cells[1::2])}


def _columns(kinds: Sequence[str], parts: Sequence[str], axes: Sequence[str]) -> list[int]:
    """The first column of every marker, of the best kind that the file has."""
    width = min(len(kinds), len(parts), len(axes) - 2)
    for kind in _MARKERS:
        found = [
            c
            for c in range(2, width)
            if kinds[c].lower() == kind and parts[c].lower() == "position" and [*axes[c : c + 3]] == ["X", "Y", "Z"]
        ]
        if found:
            return found
    return []


def _number(values: dict[str, Any], keys: Sequence[str], file: TextLines) -> float:
    key = next((key for key in keys if values.get(key)), keys[-1])
    try:
        return one_number(values[key])
    except (KeyError, ValueError):
        found = f"is '{values[key][:40]}'" if key in values else "is not there"
        raise ReadError(file.path, f"the {key} of its first line {found}", "set it there") from None
