"""What a bench finds: rows of figures, each beside its aim, and how a script prints them."""

import argparse
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple


class Row(NamedTuple):
    """One figure of one case.

    Attributes:
        case: what was measured.
        figure: of what the value is; its unit stands behind it in brackets.
        at_least, at_most: the aim, where there is one.
        size: what the case is large by, for curves.
    """

    case: str
    figure: str
    value: float
    at_least: float | None = None
    at_most: float | None = None
    size: float | None = None

    @property
    def aim(self) -> str:
        if self.at_least is not None:
            return f">= {self.at_least:g}"
        return "" if self.at_most is None else f"<= {self.at_most:g}"

    @property
    def met(self) -> str:
        if not self.aim:
            return ""
        low, high = (
            self.at_least is None or self.value >= self.at_least,
            self.at_most is None or self.value <= self.at_most,
        )
        return "met" if low and high else "missed"


HEADS = ("case", "figure", "value", "aim", "")


def cells(row: Row) -> tuple[str, ...]:
    """The row as text, in the order of `HEADS`."""
    return row.case, row.figure, f"{row.value:.4g}", row.aim, row.met


def show(rows: Iterable[Row]) -> None:
    """Prints rows as they come."""
    for row in rows:
        print("{:44} {:38} {:>9} {:>8} {}".format(*cells(row)).rstrip(), flush=True)


def run(doc: str | None, rows: Callable[[bool], Iterator[Row]]) -> None:
    """The command line of a bench: `rows(quick)` gives its rows."""
    parser = argparse.ArgumentParser(description=str(doc).splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer and smaller cases, fewer runs")
    show(rows(parser.parse_args().quick))
