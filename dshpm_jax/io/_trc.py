"""TRC text files (Motion Analysis, OpenSim): lines of keys and values, labels, axes, then the frames."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._text_table import TextLines, TextTable, end_of_rows, join, split
from dshpm_jax.io._units import length_unit

_AXES_ROW = re.compile(r"\s*X1\b", re.IGNORECASE)
_LEAD = 2  # the number of the frame and the time


@dataclass(frozen=True)
class TrcTable(TextTable):
    """A TRC file; `keys_at` is the row that starts with DataRate, `labels_at` the one that starts with Frame#."""

    keys_at: int = 0
    labels_at: int = 0

    def file_width(self) -> int:
        return _LEAD + 3 * len(self.labels)

    def head(self, names: Sequence[str], origins: Sequence[int | None], order: Sequence[int | None]) -> Iterator[str]:
        for k, line in enumerate(self.file.lines[: self.rows[0]]):
            cells = _cells(line)
            if k == self.keys_at + 1:
                keys = [key.lower() for key in _cells(self.file.lines[self.keys_at])]
                counted = [str(len(names)) if key == "nummarkers" else cell for key, cell in zip(keys, cells)]
                yield join([*counted, *cells[len(keys) :]], "\t")
            elif k == self.labels_at:
                yield join([*cells[:_LEAD], *(cell for name in names for cell in (name, "", ""))], "\t")
            elif _AXES_ROW.match(line):
                yield join(["", "", *(f"{axis}{n + 1}" for n in range(len(names)) for axis in "XYZ")], "\t")
            else:
                yield line


def trc_table(file: TextLines) -> TrcTable:
    """The markers of a TRC file."""
    lines, path = file.lines, file.path
    labels_at = next((k for k, line in enumerate(lines) if line.lower().startswith("frame#")), None)
    keys_at = next((k for k, line in enumerate(lines) if line.lower().startswith("datarate")), None)
    if labels_at is None or labels_at < 2:
        raise ReadError(path, "this is no TRC file (it has no 'Frame#' row)", "give a C3D, TRC, CSV or TSV file")
    header = {} if keys_at is None else _header(lines[keys_at:labels_at][:2])
    labels = _labels(_cells(lines[labels_at]))
    begin = labels_at + 1
    while begin < len(lines) and (not lines[begin].strip() or _AXES_ROW.match(lines[begin])):
        begin += 1
    if labels and header.get("nummarkers", "").isdecimal() and begin < len(lines):  # the last may have no names
        places = min(int(header["nummarkers"]), (len(_cells(lines[begin])) - _LEAD) // 3)
        labels += [""] * (places - len(labels))
    return TrcTable(
        file,
        (begin, max(begin, end_of_rows(lines))),
        "\t" if any("\t" in line for line in lines[begin : begin + 1]) else "",
        tuple(labels),
        tuple(_LEAD + 3 * k for k in range(len(labels))),
        _number(header, "datarate", file),
        length_unit(header.get("units", ""), path),
        _number(header, "numframes", file) if header.get("numframes") else None,
        keys_at=keys_at or 0,
        labels_at=labels_at,
    )


def _cells(line: str) -> list[str]:
    """The cells of a row, parted by tabs, or by blanks in files that have no tab at all."""
    return split(line, "\t" if "\t" in line else "")


def _header(rows: Sequence[str]) -> dict[str, str]:
    """Keys (in lower case) and values: the row that starts with DataRate and the one below it."""
    if len(rows) < 2:
        return {}
    return dict(zip((key.lower() for key in _cells(rows[0])), _cells(rows[1]), strict=False))


def _labels(cells: list[str]) -> list[str]:
    """The labels stand over the first of three columns each; an empty one is a point without a name."""
    cells = cells[_LEAD:]
    while cells and not cells[-1]:
        cells.pop()
    thirds = cells[0::3]
    if any(cell for k, cell in enumerate(cells) if k % 3):  # some writers leave out the two empty cells
        return [cell for cell in cells if cell]
    return thirds


def _number(header: dict[str, str], key: str, file: TextLines) -> float:
    try:
        return float(header[key])
    except (KeyError, ValueError):
        found = f"is '{header[key]}'" if key in header else "is not there"
        wrong = f"the number {key} of its header {found}"
        raise ReadError(file.path, wrong, "set it in the second and third line") from None
