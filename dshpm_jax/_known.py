"""Labels that are given with a recording, as a person or its file says them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class KnownLabel:
    """Some points of a recording of which the label is known: a column, over a span of frames or all of it.

    Attributes:
        column: of the source file, from 0, as `Recording.columns` counts them.
        first, last: the span, frames `first <= t < last` from 0; to the end of the recording where `last` is None.
        label: the marker's name as the labelling calls it (with the subject's before it where there are several), or
            None where the points are no marker.

    Raises:
        ValueError: the column or the span cannot be.
    """

    column: int
    first: int = 0
    last: int | None = None
    label: str | None = None

    def __post_init__(self):
        if self.column < 0 or self.first < 0 or (self.last is not None and self.last <= self.first):
            raise ValueError(f"{self}: columns and frames count from 0, and a span ends after its first frame")

    def __str__(self) -> str:
        until = "the end" if self.last is None else f"{self.last - 1}"
        return f"column {self.column + 1}, frames {self.first} to {until}: {self.label or 'no marker'}"
