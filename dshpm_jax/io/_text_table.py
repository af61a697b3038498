"""Recordings as text: a row a frame, three cells a point, below a head that each program writes in its own way.

A table keeps its file's lines as they are, so that whoever writes it again with other labels changes nothing else: no
number is read and printed, cells move as text.
"""

import abc
import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from io import StringIO
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._far import set_far_missing
from dshpm_jax.io._numbers import MixedMarks, RowReader
from dshpm_jax.io._raw import Raw
from dshpm_jax.io._units import HIGHEST_RATE, LOWEST_RATE, MILLIMETRES

_MARKS = {b"\xef\xbb\xbf": "utf-8", b"\xff\xfe": "utf-16-le", b"\xfe\xff": "utf-16-be"}
_LOOKED_AT = 4096  # bytes


@dataclass(frozen=True)
class TextLines:
    """A text file, line by line.

    Attributes:
        lines: without their ends.
        encoding: "utf-8", "utf-16-le", "utf-16-be", or "latin-1" where it is none of these.
        mark: the bytes that the file begins with to say so, if it does.
        end: what the lines end with.
    """

    path: Path
    lines: Sequence[str]
    encoding: str
    end: str
    mark: bytes = b""


@dataclass(frozen=True)
class TextTable(abc.ABC):
    """A recording as its text file has it.

    Attributes:
        file: the lines of the whole file.
        rows: the first line with a frame, and the first one behind the last.
        delimiter: between cells; empty for any number of blanks.
        labels: of all points, as the file has them.
        columns: the first cell of each point's three.
        rate: frames a second.
        unit: the file's length unit.
        announced: how many frames the file says that it has, if it does.
        numbered: whether the first cell of a row is the number of its frame.
        stride: how many cells a point has: its coordinates, and what else moves with it.
        notes: what was doubtful, a sentence each.
    """

    file: TextLines
    rows: tuple[int, int]
    delimiter: str
    labels: tuple[str, ...]
    columns: tuple[int, ...]
    rate: float
    unit: str
    announced: float | None = None
    numbered: bool = True
    stride: int = 3
    notes: tuple[str, ...] = ()

    @abc.abstractmethod
    def head(self, names: Sequence[str], origins: Sequence[int | None], order: Sequence[int | None]) -> Iterator[str]:
        """The lines before the first frame, for other points in other columns.

        Arguments:
            names: new labels.
            origins: for each the point of this table that it is throughout, if there is one.
            order: for each cell of the new rows the cell of the old head that stands over it; None over new points.
        """

    @abc.abstractmethod
    def file_width(self) -> int:
        """How many cells the head gives a row; more are none of this table's."""

    def frames(self) -> Iterator[tuple[int, list[str]]]:
        """Number of the line (from 1) and cells of every row that is not empty.

        In rows without numbers cells that are all empty are a frame in which nothing was seen.
        """
        for k in range(*self.rows):
            if self.is_frame(k):
                yield k + 1, split(self.file.lines[k], self.delimiter)

    def is_frame(self, k: int) -> bool:
        """Whether a line (from 0) of those of the frames holds one."""
        line = self.file.lines[k]
        return bool(line.strip(" \t,;")) or (not self.numbered and bool(self.delimiter) and self.delimiter in line)

    def first_frame(self) -> int:
        """The number that the file gives its first frame; 1 where it gives none."""
        cells = next((cells for _, cells in self.frames()), [""])
        number = cells[0].strip().removesuffix(".0")
        return int(number) if self.numbered and number.isdecimal() else 1


def read_lines(path: Path) -> TextLines:
    """The lines of a text file; raises `ReadError` where it cannot be read or is empty."""
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise ReadError(path, f"cannot be read ({error.strerror})", "check the path and its permissions") from None
    if not raw.strip():
        raise ReadError(path, "the file is empty", "export it again")
    encoding, mark = encoding_of(raw)
    try:
        text = raw.removeprefix(mark).decode(encoding)
    except UnicodeDecodeError:
        encoding, mark = "latin-1", b""
        text = raw.decode(encoding)
    end = "\r\n" if "\r\n" in text else "\n" if "\n" in text else "\r"
    lines = [line.removesuffix("\r") for line in text.split("\n" if "\n" in text else "\r")]
    return TextLines(path, lines, encoding, end, mark)


def encoding_of(raw: bytes) -> tuple[str, bytes]:
    """The encoding that a text seems to have, and the mark that it begins with."""
    for mark, encoding in _MARKS.items():
        if raw.startswith(mark):
            return encoding, mark
    start = raw[:_LOOKED_AT]
    if 2 * start[1::2].count(0) > len(start) // 2:  # letters of our alphabet have an empty byte in UTF-16
        return "utf-16-le", b""
    return ("utf-16-be" if 2 * start[::2].count(0) > len(start) // 2 else "utf-8"), b""


def end_of_rows(lines: Sequence[str]) -> int:
    """The line behind the last one that is not empty."""
    return next((k + 1 for k in range(len(lines) - 1, -1, -1) if lines[k].strip(" \t,;")), 0)


def split(line: str, delimiter: str) -> list[str]:
    """The cells of a line, without blanks around them."""
    if not delimiter:
        return line.split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    try:
        cells = next(csv.reader([line.replace("\0", "")], delimiter=delimiter), [])
    except csv.Error:  # a quote that never ends
        cells = line.split(delimiter)
    return [cell.strip() for cell in cells]


def join(cells: Sequence[str], delimiter: str) -> str:
    """A line of cells; what would fall apart again is quoted."""
    if not any(delimiter in cell or '"' in cell for cell in cells):
        return delimiter.join(cells)
    text = StringIO()
    csv.writer(text, delimiter=delimiter, lineterminator="").writerow(cells)
    return text.getvalue()


def raw_of_table(table: TextTable) -> Raw:
    """The points that a table holds."""
    path = table.file.path
    if not table.labels:
        raise ReadError(path, "it holds no points", "export it with its trajectories")
    if not LOWEST_RATE <= table.rate <= HIGHEST_RATE:
        raise ReadError(path, f"its rate is {table.rate:g} frames a second", "set it in the head of the file")
    points = _positions(table)
    unit = MILLIMETRES[table.unit]
    with np.errstate(over="ignore"):
        points *= unit
    points[(points == 0).all(-1)] = np.nan
    notes = (*table.notes, *set_far_missing(points, unit))
    columns = tuple(range(len(table.labels)))
    return Raw(path, points, table.labels, columns, table.rate, table.unit, notes=notes)


def _positions(table: TextTable) -> Float[np.ndarray, "frames points 3"]:
    """Coordinates in the file's unit; a cell that is empty or cut off is NaN."""
    cells_of = [c + k for c in table.columns for k in range(3)]
    width, most = max(cells_of) + 1, table.file_width()
    numbers = RowReader()
    rows = []
    for line, cells in table.frames():
        if len(cells) < width and not table.delimiter:
            wrong = f"line {line} has fewer numbers than its {len(table.labels)} labels need"
            raise ReadError(table.file.path, wrong, "export it with tabs, which show where points are missing")
        if len(cells) < width:
            cells = cells + [""] * (width - len(cells))
        elif any(cells[most:]):
            wrong = f"line {line} has more numbers than its {len(table.labels)} labels need"
            raise ReadError(table.file.path, wrong, "export it again")
        try:
            rows.append(numbers([cells[c] for c in cells_of]))
        except MixedMarks:
            wrong = f"up to line {line} it has numbers with decimal points and others with decimal commas"
            raise ReadError(table.file.path, wrong, "export it with points alone") from None
        except ValueError:
            raise ReadError(
                table.file.path, f"line {line} holds something that is no number", "export it again"
            ) from None
    return np.array(rows, dtype=np.float64).reshape(-1, len(table.columns), 3)


def whole_rows(table: TextTable) -> TextTable:
    """The table without a last row that was cut off, and with a note if frames are missing at the end."""
    lines = [k for k in range(*table.rows) if table.is_frame(k)]
    announced = len(lines) if table.announced is None else table.announced
    short = len(lines) < announced
    ended = not table.file.lines[-1]
    if lines and (short or (table.announced is None and not ended)) and _is_cut(table, lines, short and not ended):
        end = lines.pop()
        note = f"its last row, line {end + 1}, is cut off: left out"
        table = replace(table, rows=(table.rows[0], end), notes=(*table.notes, note))
    if short:
        note = f"it announces {announced:g} frames and ends after {len(lines)} (truncated): those are read"
        table = replace(table, notes=(*table.notes, note))
    return table


def _is_cut(table: TextTable, lines: Sequence[int], surely: bool) -> bool:
    """Whether the last of `lines` has fewer cells than any of the others."""
    if not table.delimiter or len(lines) < 2:
        return surely
    cells = [table.file.lines[k].count(table.delimiter) for k in lines]
    return surely or cells[-1] < min(cells[:-1])


def rearranged_lines(
    table: TextTable, source: Int[np.ndarray, "frames columns"], names: Sequence[str], present: Bool[np.ndarray, "..."]
) -> Iterator[str]:
    """The lines of the file with column `k` taken from point `source[t, k]` of frame `t` and named `names[k]`.

    A negative source leaves the cells empty, or as the file spells a gap where the column is one point's throughout.
    Cells that belong to no point come along, behind the points.

    Arguments:
        present: where the points of the table are seen, as (frames, points).
    """
    origins = [_only(column) for column in source.T]
    for column, point in zip(source.T, origins):
        if point is not None:
            column[(column < 0) & ~present[:, point]] = point
    width = table.file_width()
    points = {c + k for c in table.columns for k in range(table.stride)}
    lead = min(points)
    others = [c for c in range(lead, width) if c not in points]
    order: list[int | None] = [*range(lead), *[None] * (table.stride * len(names)), *others]
    delimiter = table.delimiter or "\t"
    yield from table.head(names, origins, order)
    for (_, cells), row in zip(table.frames(), source, strict=True):
        cells = cells + [""] * (width - len(cells))
        moved = [cells[table.columns[p] + k] if p >= 0 else "" for p in row for k in range(table.stride)]
        yield join([*cells[:lead], *moved, *(cells[c] for c in others)], delimiter)
    yield from table.file.lines[table.rows[1] :]


def _only(column: Int[np.ndarray, " frames"]) -> int | None:
    """The point that a new column comes from, if it is one alone."""
    found = np.unique(column[column >= 0])
    return int(found[0]) if len(found) == 1 else None


def encoded(lines: Iterator[str], file: TextLines) -> Iterator[bytes]:
    """Lines as `file` would hold them, ends and mark included; its last line had no end."""
    yield file.mark
    before = ""
    for line in lines:
        yield (before + line).encode(file.encoding, "replace")
        before = file.end
