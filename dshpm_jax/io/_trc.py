"""TRC text files (Motion Analysis, OpenSim): lines of keys and values, labels, axes, then the frames."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._numbers import one_number
from dshpm_jax.io._text_table import TextLines, TextTable, end_of_rows, join, split
from dshpm_jax.io._units import length_unit

_LABELS_ROW = re.compile(r'\W*frame\s*(#|no\.?|number)?"?\s*([\t,;]|\stime\b)|frame#', re.IGNORECASE)
_AXIS = re.compile(r"([XYZ])(\d*)", re.IGNORECASE)
_LEAD = 2  # the number of the frame and the time
_MOST_HEAD = 5  # lines between the labels and the first frame


@dataclass(frozen=True)
class TrcTable(TextTable):
    """A TRC file; `keys_at` is the row that starts with DataRate, `labels_at` the one that starts with Frame#."""

    keys_at: int = 0
    labels_at: int = 0

    def file_width(self) -> int:
        return _LEAD + 3 * len(self.labels)

    def head(self, names: Sequence[str], origins: Sequence[int | None], order: Sequence[int | None]) -> Iterator[str]:
        delimiter = self.delimiter or "\t"
        for k, line in enumerate(self.file.lines[: self.rows[0]]):
            cells = _cells(line, self.delimiter)
            if k == self.keys_at + 1:
                keys = [key.lower() for key in _cells(self.file.lines[self.keys_at], self.delimiter)]
                counted = [str(len(names)) if key == "nummarkers" else cell for key, cell in zip(keys, cells)]
                yield join([*counted, *cells[len(keys) :]], delimiter)
            elif k == self.labels_at:
                yield join([*cells[:_LEAD], *(cell for name in names for cell in (name, "", ""))], delimiter)
            elif k > self.labels_at and (first := _first_axis(cells)) is not None:
                axes = [f"{axis}{first + n if first >= 0 else ''}" for n in range(len(names)) for axis in "XYZ"]
                yield join(["", "", *axes], delimiter)
            else:
                yield line


def trc_table(file: TextLines) -> TrcTable:
    """The markers of a TRC file, and its points that have no name: a row has as many points as it has."""
    lines, path = file.lines, file.path
    labels_at = next((k for k, line in enumerate(lines) if _LABELS_ROW.match(line)), None)
    keys_at = next((k for k, line in enumerate(lines) if line.lower().lstrip('"').startswith("datarate")), None)
    if labels_at is None or labels_at < 2:
        raise ReadError(path, "this is no TRC file (it has no 'Frame#' row)", "give a C3D, TRC, CSV or TSV file")
    begin = _first_row(lines, labels_at)
    delimiter = _delimiter(lines[labels_at], lines[begin : begin + 1])
    header = {} if keys_at is None else _header(lines[keys_at:labels_at][:2], delimiter)
    labels = _labels(_cells(lines[labels_at], delimiter))
    rows = (begin, max(begin, end_of_rows(lines)))
    points = _points(lines[rows[0] : rows[1]], delimiter)
    announced = header.get("nummarkers", "")
    notes = []
    if points > max(len(labels), int(announced) if announced.isdecimal() else 0):
        notes = [f"it has {len(labels)} names and up to {points} points a row: those beyond have no name"]
    if labels and announced.isdecimal() and begin < len(lines):  # the last may have no names, and not be seen either
        points = max(points, min(int(announced), (len(_cells(lines[begin], delimiter)) - _LEAD) // 3))
    labels += [""] * (points - len(labels))
    return TrcTable(
        file,
        rows,
        delimiter,
        tuple(labels),
        tuple(_LEAD + 3 * k for k in range(len(labels))),
        _number(header, "datarate", file),
        length_unit(header.get("units", ""), path),
        _number(header, "numframes", file) if header.get("numframes") else None,
        notes=tuple(notes),
        keys_at=keys_at or 0,
        labels_at=labels_at,
    )


def _first_row(lines: Sequence[str], labels_at: int) -> int:
    """The first line with a frame: what stands between it and the labels begins with no number."""
    for k in range(labels_at + 1, min(labels_at + 1 + _MOST_HEAD, len(lines))):
        if re.match(r'[\s"]*[-+]?\d', lines[k]):
            return k
    return min(labels_at + 1 + _MOST_HEAD, len(lines))


def _delimiter(labels: str, rows: Sequence[str]) -> str:
    """What parts the cells of the rows; nothing for any number of blanks."""
    return next((mark for mark in "\t;," if mark in labels and all(mark in row for row in rows)), "")


def _cells(line: str, delimiter: str) -> list[str]:
    """The cells of a row, parted by what parts those of the frames, else by tabs or blanks."""
    return split(line, delimiter if delimiter and delimiter in line else "\t" if "\t" in line else "")


def _header(rows: Sequence[str], delimiter: str) -> dict[str, str]:
    """Keys (in lower case) and values: the row that starts with DataRate and the one below it."""
    if len(rows) < 2:
        return {}
    keys, values = (_cells(row, delimiter) for row in rows)
    return dict(zip((key.lower() for key in keys), values, strict=False))


def _labels(cells: list[str]) -> list[str]:
    """The labels stand over the first of three columns each; an empty one is a point without a name."""
    cells = cells[_LEAD:]
    while cells and not cells[-1]:
        cells.pop()
    thirds = cells[0::3]
    if any(cell for k, cell in enumerate(cells) if k % 3):  # some writers leave out the two empty cells
        return [cell for cell in cells if cell]
    return thirds


def _points(rows: Sequence[str], delimiter: str) -> int:
    """How many whole points the longest row has; rows parted by blanks are as long as their labels say."""
    if not delimiter:
        return 0
    longest = max((len(row.rstrip(delimiter + " ").split(delimiter)) for row in rows), default=0)
    return max(0, longest - _LEAD) // 3


def _first_axis(cells: Sequence[str]) -> int | None:
    """The number in the first cell of a row of axes, -1 where they have none; None where it is no such row."""
    found = [_AXIS.fullmatch(cell) for cell in cells if cell]
    if not found or found[0] is None:
        return None
    return int(found[0][2]) if found[0][2] else -1


def _number(header: dict[str, str], key: str, file: TextLines) -> float:
    try:
        return one_number(header[key])
    except (KeyError, ValueError):
        found = f"is '{header[key]}'" if key in header else "is not there"
        wrong = f"the number {key} of its header {found}"
        raise ReadError(file.path, wrong, "set it in the second and third line") from None
