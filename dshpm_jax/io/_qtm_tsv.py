"""TSV files of Qualisys Track Manager: lines of keys and values, then the frames."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from dshpm_jax.io._errors import NoPoints, ReadError
from dshpm_jax.io._numbers import one_number
from dshpm_jax.io._text_table import TextLines, TextTable, end_of_rows, join, split

_REMEDY = "export it again as 3D data"
_LEADING = ("frame", "time")
_TRIED = 1000  # rows in which the last point is looked for


@dataclass(frozen=True)
class QtmTable(TextTable):
    """A 3D export; coordinates are in millimetres, and there may be a row that names every column."""

    names_at: int = 0
    header_at: int | None = None

    def file_width(self) -> int:
        return self.columns[-1] + self.stride if self.columns else 0

    def head(self, names: Sequence[str], origins: Sequence[int | None], order: Sequence[int | None]) -> Iterator[str]:
        for k, line in enumerate(self.file.lines[: self.rows[0]]):
            cells = split(line, "\t")
            key = cells[0].upper() if cells else ""
            if k == self.names_at:
                yield join([cells[0], *names], "\t")
            elif key == "NO_OF_MARKERS":
                yield join([cells[0], str(len(names))], "\t")
            elif key == "TRAJECTORY_TYPES":
                kinds = cells[1:]
                yield join([cells[0], *(_kind(kinds, origin) for origin in origins)], "\t")
            elif k == self.header_at:
                lead = [cell for c, cell in enumerate(cells) if c < self.columns[0]]
                own = ("X", "Y", "Z", "Residual")[: self.stride]
                yield join([*lead, *(f"{name} {axis}" for name in names for axis in own)], "\t")
            else:
                yield line


def qtm_table(file: TextLines) -> QtmTable:
    """The markers of a QTM export."""
    head = _head(file)
    included = _value(file, head, "DATA_INCLUDED")
    if included and included.upper() != "3D":
        bodies = ", which are places of rigid bodies," if included.upper().startswith("6D") else ","
        raise NoPoints(file.path, f"it holds {included[:20]} data{bodies} no markers", _REMEDY)
    if "MARKER_NAMES" not in head:
        raise ReadError(file.path, "this is no TSV file of QTM with markers (no MARKER_NAMES)", _REMEDY)
    labels = split(file.lines[head["MARKER_NAMES"]], "\t")[1:]
    while labels and not labels[-1]:
        labels.pop()
    begin = max(head.values()) + 1
    announced = _value(file, head, "NO_OF_MARKERS")
    if announced.isdecimal() and len(labels) < int(announced) <= 100_000:
        labels += [""] * (int(announced) - len(labels))
    header_at = begin if begin < len(file.lines) and _is_header(file.lines[begin]) else None
    begin += header_at is not None
    stride = _stride(file, header_at, begin, len(labels))
    lead = _leading(file, header_at, begin, stride * len(labels))
    frames = _number(file, head, "NO_OF_FRAMES") if _value(file, head, "NO_OF_FRAMES") else None
    end = max(begin, end_of_rows(file.lines))
    if not lead and frames is not None and frames < len(file.lines):  # in the last ones nothing may have been seen
        end = max(end, min(len(file.lines), begin + int(frames)))
    return QtmTable(
        file,
        (begin, end),
        "\t",
        tuple(labels),
        tuple(lead + stride * k for k in range(len(labels))),
        _number(file, head, "FREQUENCY"),
        "mm",
        frames,
        lead > 0,
        stride,
        names_at=head["MARKER_NAMES"],
        header_at=header_at,
    )


def _head(file: TextLines) -> dict[str, int]:
    """The line of each key: those from the top on that begin with a word in capitals."""
    found: dict[str, int] = {}
    for k, line in enumerate(file.lines):
        key = line.split("\t", 1)[0].strip()
        if not key or key.upper() != key or not key.replace("_", "").isalpha():
            break
        found[key] = k
    return found


def _is_header(line: str) -> bool:
    """Whether a line names columns: the first cell that is not empty is no number."""
    cell = next((cell for cell in split(line, "\t") if cell), "0")
    try:
        one_number(cell)
    except ValueError:
        return True
    return False


def _stride(file: TextLines, header_at: int | None, begin: int, points: int) -> int:
    """How many cells a point has: its coordinates, and its residual where the export has that."""
    if header_at is not None:
        names = [cell.lower() for cell in split(file.lines[header_at], "\t")]
        return 4 if sum(name.endswith("residual") for name in names) >= points > 0 else 3
    row = next((split(line, "\t") for line in file.lines[begin : begin + _TRIED] if line.strip()), [])
    while row and not row[-1]:
        row.pop()
    return 4 if points > len(_LEADING) and len(row) in range(4 * points, 4 * points + len(_LEADING) + 1) else 3


def _leading(file: TextLines, header_at: int | None, begin: int, cells_of_points: int) -> int:
    """How many cells stand before the first point: the frame, and the time, where the export has them."""
    if header_at is not None:
        cells = [cell.lower() for cell in split(file.lines[header_at], "\t")]
        return sum(cell in _LEADING for cell in cells[: len(_LEADING)])
    rows = [split(line, "\t") for line in file.lines[begin : begin + _TRIED] if line.strip()]
    full = [row for row in rows if row[-1]]  # others may end in a tab too many
    found = len(full[0]) if full else max(map(len, rows), default=0) - 1
    return min(max(found - cells_of_points, 0), len(_LEADING))


def _value(file: TextLines, head: dict[str, int], key: str) -> str:
    cells = split(file.lines[head[key]], "\t") if key in head else []
    return cells[1] if len(cells) > 1 else ""


def _number(file: TextLines, head: dict[str, int], key: str) -> float:
    text = _value(file, head, key)
    try:
        return one_number(text)
    except ValueError:
        found = f"is '{text[:40]}'" if key in head else "is not there"
        raise ReadError(file.path, f"the number {key} of its head {found}", "set it there") from None


def _kind(kinds: Sequence[str], origin: int | None) -> str:
    """How a trajectory came to be; one that is made of several is a mixed one."""
    return "Mixed" if origin is None else kinds[origin] if origin < len(kinds) else ""
