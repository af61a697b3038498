"""A recording on the host: points in frames, in millimetres, with or without names."""

import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from dshpm_jax._geometry import is_seen

UNLABELLED = re.compile(
    r"(\*\d*|#\d*|\*?[Uu]nnamed.*|U_?\d+|[Uu]nlabel+ed.*|[Uu]nidentified.*|New \d+|uname.*|M\d{3,}|C_\d+|x\d{2,}"
    r"|\d+ \d+|)"
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


def of_one_name(recording: Recording) -> dict[str, list[int]]:
    """Names that several columns have in which something is seen, and those columns."""
    found: dict[str, list[int]] = {}
    for column in np.flatnonzero(recording.labelled & recording.present.any(0)):
        found.setdefault(recording.labels[column], []).append(int(column))
    return {name: columns for name, columns in found.items() if len(columns) > 1}


def check_names_apart(recording: Recording, take_turns: bool = True) -> None:
    """Raises ValueError where two columns have one name.

    Arguments:
        take_turns: whether they may, in frames of their own.
    """
    for name, columns in of_one_name(recording).items():
        together = int((recording.present[:, columns].sum(1) > 1).sum())
        if together or not take_turns:
            numbers = [recording.columns[column] + 1 for column in columns]
            where = " and ".join(map(str, numbers))
            source = recording.source.name if recording.source else "an unnamed recording"
            raise ValueError(
                f"{source}: columns {where} are both named {name!r}, in {together} frames at the same time; rename "
                f"one, or leave one out with --drop '#{numbers[-1]}'"
            )
