"""CSV files of Vicon Nexus, Shogun and Tracker: sections, of which "Trajectories" holds the markers."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._numbers import one_number
from dshpm_jax.io._text_table import TextLines, TextTable, join, split
from dshpm_jax.io._units import length_unit

_SECTION = re.compile(r"\W*Trajectories\W*", re.IGNORECASE)
_REMEDY = "export it again with its trajectories"


@dataclass(frozen=True)
class ViconTable(TextTable):
    """A section "Trajectories": its name, the rate, labels over the first of three columns, axes, units, frames."""

    labels_at: int = 0

    def file_width(self) -> int:
        return len(split(self.file.lines[self.labels_at + 1], self.delimiter))

    def head(self, names: Sequence[str], origins: Sequence[int | None], order: Sequence[int | None]) -> Iterator[str]:
        lines, labels_at = self.file.lines, self.labels_at
        yield from lines[:labels_at]
        above = iter([cell for name in names for cell in (name, "", "")])
        for row, new in ((labels_at, above), (labels_at + 1, _again("XYZ", names)), (labels_at + 2, None)):
            old = split(lines[row], self.delimiter)
            new = _again([old[c] for c in range(self.columns[0], self.columns[0] + 3)], names) if new is None else new
            yield join([_cell(old, c) if c is not None else next(new) for c in order], self.delimiter)
        yield from lines[labels_at + 3 : self.rows[0]]


def is_vicon(file: TextLines) -> bool:
    return _section(file) is not None


def vicon_table(file: TextLines) -> ViconTable:
    """The section "Trajectories" of a file."""
    start = _section(file)
    if start is None:
        raise ReadError(file.path, "it has no section 'Trajectories'", _REMEDY)
    axes_at = _axes_row(file, start)
    delimiter = max(",;\t", key=file.lines[axes_at].count)
    labels, axes, units = (split(file.lines[row], delimiter) for row in (axes_at - 1, axes_at, axes_at + 1))
    columns = [c for c in range(2, len(axes) - 2) if [a.upper() for a in axes[c : c + 3]] == ["X", "Y", "Z"]]
    below = axes_at + 2
    end = next((k for k in range(below, len(file.lines)) if not file.lines[k].strip(" \t,;")), len(file.lines))
    unit = next((units[c] for c in columns if c < len(units) and units[c]), "")
    return ViconTable(
        file,
        (below, end),
        delimiter,
        tuple(labels[c] if c < len(labels) else "" for c in columns),
        tuple(columns),
        _rate(file, start, axes_at),
        length_unit(unit, file.path),
        labels_at=axes_at - 1,
    )


def _section(file: TextLines) -> int | None:
    return next((k for k, line in enumerate(file.lines) if _SECTION.fullmatch(line.strip(" \t,;"))), None)


def _axes_row(file: TextLines, start: int) -> int:
    for k in range(start + 2, min(start + 6, len(file.lines) - 1)):
        if file.lines[k].lstrip(' "').lower().startswith("frame"):
            return k
    raise ReadError(file.path, "its section 'Trajectories' has no row 'Frame, Sub Frame, X, Y, Z'", _REMEDY)


def _rate(file: TextLines, start: int, axes_at: int) -> float:
    text = file.lines[start + 1].strip(' \t,;"')
    try:
        return one_number(text) if start + 1 < axes_at - 1 else float("nan")
    except ValueError:
        raise ReadError(
            file.path, f"its rate is '{text[:40]}', which is no number", "set it below 'Trajectories'"
        ) from None


def _cell(cells: Sequence[str], column: int) -> str:
    return cells[column] if column < len(cells) else ""


def _again(cells: Sequence[str], names: Sequence[str]) -> Iterator[str]:
    """The same three cells for every name."""
    return iter([cell for _ in names for cell in cells])
