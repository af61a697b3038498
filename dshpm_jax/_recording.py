"""A recording on the host: points in frames, in millimetres, with or without names."""

import re
from collections.abc import Sequence
from dataclasses import InitVar, dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from dshpm_jax._geometry import is_seen

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
"""How many millimetres a unit has."""

UNLABELLED = re.compile(
    r"(\*\d*|#\d*|\*?[Uu]nnamed.*|U_?\d+|[Uu]nlabel+ed.*|[Uu]nidentified.*|New \d+|uname.*|M\d{3,}|C_\d+|x\d{2,}"
    r"|\d+ \d+|)"
)
"""Names that capture systems give to columns that nobody has named (matched in full)."""

SHOWN_NAMES = 8
"""count; names that a message lists at most, where none is near the one that was asked for."""


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

    `recording["LKNE"]` gives the places of one marker, `"LKNE" in recording` says whether a column has that name.

    Attributes:
        points: positions in millimetres, NaN in all three coordinates where a point was not seen.
        labels: one name a column, without the subject's prefix; empty or a capture system's placeholder
            (see `is_unlabelled`) where a column has no name.
        rate: frames a second (Hz), positive.
        unit: the length unit of files, in which the recording is written: "mm", "cm" or "m". It says nothing about
            `points`, which are in millimetres whatever it is.
        source: the file that it came from, if any.
        columns: for each column of `points` its column in the source file (model outputs are left out of `points`).
        notes: what was doubtful about the source file, a sentence each.
        points_unit: when a recording is made, the unit that the points are given in, "mm", "cm" or "m"; they are
            converted, so that afterwards it is always "mm".

    Raises:
        ValueError: the shapes do not go together, the rate is no positive number, or the unit of the points is unknown.
    """

    points: Float[np.ndarray, "frames points 3"]
    labels: tuple[str, ...]
    rate: float
    unit: str = "mm"
    source: Path | None = None
    columns: tuple[int, ...] = field(default=())
    notes: tuple[str, ...] = ()
    points_unit: InitVar[str] = "mm"

    def __post_init__(self, points_unit: str):
        points = np.asarray(self.points)
        if points.ndim != 3 or points.shape[-1] != 3:
            raise ValueError(f"points must have the shape (frames, points, 3), got {points.shape}")
        if len(self.labels) != points.shape[1]:
            raise ValueError(f"{points.shape[1]} columns of points but {len(self.labels)} labels")
        if not (np.isfinite(self.rate) and self.rate > 0):
            raise ValueError(f"the rate must be a positive number of frames a second, got {self.rate}")
        if points_unit not in MILLIMETRES:
            raise ValueError(f"points_unit must be one of {', '.join(MILLIMETRES)}, got {points_unit!r}")
        if points_unit != "mm":
            points = points * MILLIMETRES[points_unit]
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "labels", tuple(self.labels))
        if not self.columns:
            object.__setattr__(self, "columns", tuple(range(points.shape[1])))

    def __repr__(self) -> str:
        size = f"{self.num_frames} frames at {self.rate:g} Hz"
        named = f"{int(self.labelled.sum())} of {len(self.labels)} columns named"
        return f"Recording({size}, {named}{f', from {self.source.name}' if self.source else ''})"

    __iter__ = None  # a name in brackets does not make it a sequence

    def __contains__(self, label: object) -> bool:
        return label in self.labels

    def __getitem__(self, label: str) -> Float[np.ndarray, "frames 3"]:
        """Where the column of that name is (mm), NaN where it was not seen.

        Several columns may have one name, as long as they take turns.

        Raises:
            KeyError: no column has that name; the message tells names that are near.
            ValueError: two columns of that name are seen in one frame.
        """
        columns = [k for k, name in enumerate(self.labels) if name == label]
        if not columns:
            raise KeyError(no_such_name(label, self.labels, "column"))
        seen = self.present[:, columns]
        if (seen.sum(1) > 1).any():
            raise ValueError(f"{len(columns)} columns are called {label!r} and seen together; use points and labels")
        if len(columns) == 1:
            return self.points[:, columns[0]]
        place = np.where(seen[..., None], self.points[:, columns], 0.0).sum(1)
        return np.where(seen.any(1, keepdims=True), place, np.nan)

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

    def to_dataframe(self) -> Any:
        """The points as a table of pandas (`pip install 'dshpm-jax[pandas]'`).

        Returns:
            a `pandas.DataFrame` in millimetres, a row for each frame. Its index is the time (seconds, from 0), its
            columns are pairs of marker and axis, so that `table["LKNE"]["z"]` is one coordinate. Columns without a
            name are called `*1`, `*2`, ... by their place; further columns of one name get a number.

        Raises:
            ImportError: pandas is not installed.
        """
        from dshpm_jax._bridges.table import dataframe

        return dataframe(self)

    @classmethod
    def from_ezc3d(cls, c3d: Any) -> "Recording":
        """The points of an `ezc3d.c3d`, or of a dictionary that is made like it.

        Every point becomes a column, also what a model computed, which `read` leaves out.

        Arguments:
            c3d: has `["data"]["points"]` as (4, points, frames), and `["parameters"]["POINT"]` with LABELS, RATE and
                UNITS; without a unit the points are millimetres.

        Raises:
            ValueError: the points have another shape, the unit is unknown, or there is no rate.
        """
        from dshpm_jax._bridges.c3d_array import from_c3d

        return from_c3d(c3d)

    def to_ezc3d(self) -> Any:
        """A new `ezc3d.c3d` with the points as (4, points, frames) in `unit`, their names and their rate.

        Analog data and events of the source are not in it; `write_labelled` keeps them.

        Raises:
            ImportError: ezc3d is not installed.
        """
        from dshpm_jax._bridges.c3d_array import to_c3d

        return to_c3d(self)

    @classmethod
    def from_kineticstoolkit(cls, series: Any, rate: float | None = None) -> "Recording":
        """The points of a `kineticstoolkit.TimeSeries`, such as `ktk.read_c3d(...)["Points"]`.

        Arguments:
            series: its `data` holds an array (frames, 4) for each marker, in the unit that `data_info` says, metres
                where it says none; what has another shape is left out.
            rate: frames a second (Hz); by default that of its times.

        Raises:
            ValueError: there is no such array, a unit is unknown, or the times are not evenly spaced.
        """
        from dshpm_jax._bridges.time_series import from_time_series

        return from_time_series(series, rate)

    def to_kineticstoolkit(self) -> Any:
        """A `kineticstoolkit.TimeSeries`: times in seconds from 0, for each column an array (frames, 4) in metres.

        Raises:
            ImportError: kineticstoolkit is not installed.
        """
        from dshpm_jax._bridges.time_series import to_time_series

        return to_time_series(self)


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


def no_such_name(label: object, labels: Sequence[str], thing: str) -> str:
    """Says that no `thing`, such as a column, has this name, and which names are near."""
    if not isinstance(label, str):
        return f"a {thing} is asked for by its name, got {label!r}"
    named = {name.lower(): name for name in labels if not is_unlabelled(name)}
    wanted = bare_label(label).lower()
    close = [wanted] if wanted in named else get_close_matches(wanted, list(named), cutoff=0.5)
    near = [named[name] for name in close]
    some = ", ".join(list(named.values())[:SHOWN_NAMES]) or "none"
    return f"no {thing} is called {label!r}; " + (f"did you mean {' or '.join(near)}?" if near else f"there are {some}")
