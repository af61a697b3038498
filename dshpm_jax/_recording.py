"""A recording on the host: points in frames, in millimetres, with or without names."""

import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from dshpm_jax._trajectories import is_seen

UNLABELLED = re.compile(
    r"(\*\d*|#\d*|\*?[Uu]nnamed.*|U_?\d+|[Uu]nlabel+ed.*|[Uu]nidentified.*|New \d+|uname.*|M\d{3,}|C_\d+|x\d{2,}|\d+ \d+|)"
)
"""Names that capture systems give to columns that nobody has named (matched in full)."""


def is_unlabelled(label: str) -> bool:
    """Whether `label` is what a capture system calls a column without a name."""
    return UNLABELLED.fullmatch(label) is not None


def bare_label(label: str) -> str:
    """`label` without the subject's prefix that some systems put before a colon (`Nick01:LASI`)."""
    label = label.strip()
    return label if is_unlabelled(label) else label.rsplit(":", 1)[-1].strip()


@dataclass(frozen=True, eq=False)
class Recording:
    """Points of one capture.

    Attributes:
        points: positions in millimetres, NaN in all three coordinates where a point was not seen.
        labels: one name a column, without the subject's prefix; empty or a capture system's placeholder
            (see `is_unlabelled`) where a column has no name.
        rate: frames a second (Hz), positive.
        unit: the file's own length unit, in which it is written back: "mm", "cm" or "m".
        source: the file that it came from, if any.
        columns: for each column of `points` its column in the source file (model outputs are left out of `points`).
        notes: what was doubtful about the source file, a sentence each.
    """

    points: Float[np.ndarray, "frames points 3"]
    labels: tuple[str, ...]
    rate: float
    unit: str = "mm"
    source: Path | None = None
    columns: tuple[int, ...] = field(default=())
    notes: tuple[str, ...] = ()

    def __post_init__(self):
        points = np.asarray(self.points)
        if points.ndim != 3 or points.shape[-1] != 3:
            raise ValueError(f"points must have the shape (frames, points, 3), got {points.shape}")
        if len(self.labels) != points.shape[1]:
            raise ValueError(f"{points.shape[1]} columns of points but {len(self.labels)} labels")
        if not (np.isfinite(self.rate) and self.rate > 0):
            raise ValueError(f"the rate must be a positive number of frames a second, got {self.rate}")
        if not self.columns:
            object.__setattr__(self, "columns", tuple(range(points.shape[1])))

    @property
    def num_frames(self) -> int:
        return self.points.shape[0]

    @property
    def present(self) -> Bool[np.ndarray, "frames points"]:
        """Where a point was seen."""
        return is_seen(self.points)

    @property
    def labelled(self) -> Bool[np.ndarray, "points"]:
        """Which columns carry a name."""
        return np.array([not is_unlabelled(label) for label in self.labels], dtype=bool)

    def frames(self, start: int | None = None, stop: int | None = None) -> "Recording":
        """The same recording cut to frames `start` to `stop`; it no longer stands for its source file."""
        return replace(self, points=self.points[start:stop], source=None)
