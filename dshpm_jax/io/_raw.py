"""What a file holds before anybody judges it: the form in which every format reaches `judged`."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float


@dataclass(frozen=True, eq=False)
class Raw:
    """Points as a file has them.

    Attributes:
        path: the file.
        points: positions in millimetres, NaN where the file has none.
        labels: of the columns, as the file spells them.
        columns: of each its column in the file.
        rate: frames a second.
        unit: the file's own, one of `MILLIMETRES`.
        prefixes: what comes before labels in this file, besides what ends in a colon; the longest first.
        unmeasured: columns that the file marks as computed in every frame, where it marks others as measured.
        notes: what was doubtful about the file, a sentence each.
    """

    path: Path
    points: Float[np.ndarray, "frames points 3"]
    labels: tuple[str, ...]
    columns: tuple[int, ...]
    rate: float
    unit: str
    prefixes: tuple[str, ...] = ()
    unmeasured: Bool[np.ndarray, " points"] | None = None
    notes: tuple[str, ...] = ()
