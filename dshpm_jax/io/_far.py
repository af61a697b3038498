"""Numbers that stand for a point that was not seen: no place that any room holds."""

import numpy as np
from jaxtyping import Float

ROOM_MM = 1e6
"""Millimetres; used in `set_far_missing`: no system measures a point a kilometre away."""

NINES = tuple(float("9" * digits) for digits in range(4, 10))
"""In the file's own unit; used in `set_far_missing`: three of them stand for a missing point in some files."""


def set_far_missing(points: Float[np.ndarray, "frames points 3"], unit: float) -> list[str]:
    """Sets points to NaN that are beyond any room, in place, and gives a sentence about them, if there are any.

    Arguments:
        points: in millimetres.
        unit: the length of the file's unit (mm).
    """
    with np.errstate(invalid="ignore"):
        finite = np.isfinite(points).all(-1)
        far = finite & ~(np.abs(points) <= ROOM_MM).all(-1)
        size = np.abs(points).min(-1)
        even = finite & (size == np.abs(points).max(-1))
    nines = even & np.isin(np.round(np.where(even, size, 0) / unit, 6), NINES)
    count = int((far | nines).sum())
    value = float(np.abs(points[far | nines]).max() / unit) if count else 0.0
    points[far | nines | ~finite] = np.nan
    return [f"{count} points at {value:.7g}, where no room reaches, are taken for missing"] if count else []
