"""Numbers as text files spell them: with a decimal point or a comma, and with words where there are none."""

import re
from collections.abc import Sequence

import numpy as np

_NONE = re.compile(
    r"[-+]?(n/?a|#n/?a|nan(\(\w*\))?|nanq|nans|null|none|nil|missing|inf(inity)?|-|--|\d?\.#(ind|qnan|snan|inf)\w*)?",
    re.IGNORECASE,
)
"""What programs write where a point was not seen (matched in full)."""

_COMMA = re.compile(r"[-+]?\d*,\d*([eE][-+]?\d+)?")


class MixedMarks(ValueError):
    """A file has numbers with a decimal point and others with a comma, so that neither can be told from the other."""


class RowReader:
    """Reads the numbers of one file row by row; all have the same decimal mark, and missing ones are NaN.

    Raises `MixedMarks`, or ValueError where a cell is no number.
    """

    def __init__(self):
        self._points = self._commas = False  # whether there was such a decimal mark

    def __call__(self, cells: Sequence[str]) -> list[float]:
        self._points = self._points or any("." in cell and not _NONE.fullmatch(cell) for cell in cells)
        try:
            row = [float(cell) if cell else np.nan for cell in cells]
        except ValueError:
            row = [self._number(cell) for cell in cells]
        if self._points and self._commas:
            raise MixedMarks
        return row

    def _number(self, cell: str) -> float:
        if _NONE.fullmatch(cell):
            return np.nan
        if not _COMMA.fullmatch(cell):
            if "," in cell and "." in cell:
                raise MixedMarks
            return float(cell)
        self._commas = True
        return float(cell.replace(",", "."))


def one_number(text: str) -> float:
    """A number that stands alone, such as a rate; raises ValueError where it is none."""
    return float(text.replace(",", ".")) if _COMMA.fullmatch(text) else float(text)
