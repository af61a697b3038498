"""How results are written: in which format, along which axes, in which unit, and with which names."""

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import evenly_spaced, is_seen
from dshpm_jax._recording import MILLIMETRES, Recording
from dshpm_jax.io._c3d_format import read_layout

AXES = "xyz"
_AXES = re.compile(r"([-+]?)([xyz])", re.IGNORECASE)

SAMPLED_FRAMES = 20
"""count; used in `doubt_of_up`: frames in which the height of the figure is looked at; by hand."""

CLEARLY_TALLER = 1.2
"""factor; used in `doubt_of_up`: if a figure reaches this much farther along another axis than upwards, it is said; by
hand: people stand in most trials, and arms that are spread reach as far as a person is tall."""


@dataclass(frozen=True)
class Form:
    """How a result is written; the ending of its name says in which format.

    Attributes:
        axes: what its axes are in the recording, as in "x,z,-y": the new y is the old z, and the new z points against
            the old y. Empty: those of the recording.
        up: the new axis that is to point up, "x", "y" or "z", in place of `axes`. A C3D file may say which one does so
            in the recording (POINT:Y_SCREEN); otherwise z does.
        unit: "mm", "cm" or "m"; empty: that of the recording.
        keep_unknown: whether a column that stays without a label keeps the name that the file gave it, where the model
            has no marker of that name.

    Raises:
        ValueError: no such axes or unit, or the axes would mirror the recording.
    """

    axes: str = ""
    up: str = ""
    unit: str = ""
    keep_unknown: bool = False

    def __post_init__(self):
        if self.axes and self.up:
            raise ValueError("axes and up say the same; leave one of them out")
        if self.up and self.up not in AXES:
            raise ValueError(f"up is x, y or z, not {self.up!r}")
        if self.unit and self.unit not in MILLIMETRES:
            raise ValueError(f"unit must be one of {', '.join(MILLIMETRES)}, not {self.unit!r}")
        if self.axes:
            _turn(self.axes)

    @property
    def changes_points(self) -> bool:
        """Whether coordinates in the result differ from those of the recording."""
        return bool(self.axes or self.up or self.unit)

    def axes_of(self, source: Path | None) -> str:
        """The axes for a recording that was read from `source`; empty where they stay."""
        if not self.up:
            return ",".join(self.axes.lower().replace("+", "").replace(",", " ").split())
        was = _up_in(source)
        return "" if was == self.up else _quarter(was, self.up)

    def of(self, recording: Recording) -> Recording:
        """The recording as it is written, with points in millimetres; `source` stays as it is."""
        axes, points = self.axes_of(recording.source), recording.points
        return replace(recording, points=points @ _turn(axes).T if axes else points, unit=self.unit or recording.unit)

    def record(self, source: Path | None) -> dict[str, str]:
        """For sidecars: the axes and the unit of a result where they were asked for."""
        axes = self.axes_of(source)
        return {**({"axes": axes} if axes else {}), **({"unit": self.unit} if self.unit else {})}

    def doubt_of_up(self, recording: Recording) -> str:
        """Says so where a figure, before it is turned by `up`, does not look as if the axis in question were up."""
        if not self.up:
            return ""
        points = recording.points[evenly_spaced(recording.num_frames, SAMPLED_FRAMES)]
        reach = np.array([np.ptp(frame[seen], axis=0) for frame in points if (seen := is_seen(frame)).any()])
        if not len(reach):
            return ""
        up, reach = AXES.index(_up_in(recording.source)), np.median(reach, axis=0)
        if reach.max() <= CLEARLY_TALLER * reach[up]:
            return ""
        return (
            f"{AXES[up]} was taken for up, but the figure reaches farthest along {AXES[reach.argmax()]}: "
            "look at the result, and say with --axes how to turn it if need be"
        )


AS_IT_IS = Form()


def _turn(axes: str) -> Float[np.ndarray, "3 3"]:
    """The rotation from the axes of a recording to new ones."""
    found = [_AXES.fullmatch(part.strip()) for part in axes.split(",")]
    if len(found) != 3 or sorted(match[2].lower() for match in found if match) != list(AXES):
        raise ValueError(f"axes are x, y and z in some order, such as x,z,-y, not {axes!r}")
    rows = [np.eye(3)[AXES.index(match[2].lower())] * (-1 if match[1] == "-" else 1) for match in found if match]
    turn = np.array(rows)
    if np.linalg.det(turn) < 0:
        raise ValueError(f"axes {axes} would mirror the recording; change the sign of one of them")
    return turn


def _quarter(old: str, new: str) -> str:
    """The quarter turn that brings the axis `old` to where `new` is, about the third."""
    third = next(axis for axis in AXES if axis not in (old, new))
    other = {new: old, third: third, old: new}
    axes = [other[axis] for axis in AXES]
    at = AXES.index(old)
    return ",".join(f"-{axis}" if k == at else axis for k, axis in enumerate(axes))


def _up_in(source: Path | None) -> str:
    """The axis that points up in a recording: what its C3D file says, or else z."""
    if source is not None and source.suffix.lower() == ".c3d" and source.is_file():
        said = read_layout(source).strings("POINT", "Y_SCREEN")
        if said and (match := _AXES.fullmatch(said[0].strip())) and match[1] != "-":
            return match[2].lower()
    return "z"
