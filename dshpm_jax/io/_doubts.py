"""What makes it doubtful that a file was read rightly, or was right itself; nothing is changed."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import is_seen
from dshpm_jax._recording import is_unlabelled

ROOM_M = 50.0
"""Metres; used in `doubts`: hardly any room lets a marker be farther from the origin."""

LEAP_M_PER_S = 40.0
"""Metres a second; used in `doubts`: no body as a whole is faster."""

LEAST_POINTS = 3
"""Points; used in `_leaps` and `_scattered_gaps`: fewer may leap, or be missing, for any reason."""

MISSING_SHARE, NEARLY_ALL = 0.3, 0.8
"""Of all cells of columns with a name; used in `_scattered_gaps`: with so many of them missing, and no run of them
longer than chance has it, a record is taken apart in the wrong places."""

CHANCE_SHARE = 0.5
"""Of the changes between seen and missing that chance gives; used in `_scattered_gaps`: real gaps are runs of frames
and change much less often."""


def doubts(points: Float[np.ndarray, "frames points 3"], labels: Sequence[str], rate: float) -> list[str]:
    """A sentence for each thing that no sound recording shows.

    Arguments:
        points: in millimetres, NaN where missing.
        labels: their names; columns without one hold other points from frame to frame.
        rate: frames a second.
    """
    named = points[:, [not is_unlabelled(label) for label in labels]]
    found = [_too_far(points), _leaps(named, rate), _scattered_gaps(named)]
    return [sentence for sentence in found if sentence]


def _too_far(points: Float[np.ndarray, "frames points 3"]) -> str:
    seen = is_seen(points)
    farthest = float(np.abs(points[seen]).max(initial=0.0)) / 1000
    if farthest <= ROOM_M:
        return ""
    return f"it has coordinates up to {farthest:.0f} m, which no room holds; check its length unit"


def _leaps(points: Float[np.ndarray, "frames points 3"], rate: float) -> str:
    """About frames from which to the next every point that is seen in both leaps."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=-1)
    counted = np.isfinite(step)
    least = np.where(counted, step, np.inf).min(1, initial=np.inf)
    enough = counted.sum(1) >= LEAST_POINTS
    leaps = np.flatnonzero(enough & np.isfinite(least) & (least > 1000 * LEAP_M_PER_S / rate))
    if not len(leaps):
        return ""
    others = f" and {len(leaps) - 1} more" if len(leaps) > 1 else ""
    return f"all its points leap by {least[leaps[0]] / 1000:.2g} m or more after frame {leaps[0] + 1}{others}"


def _scattered_gaps(points: Float[np.ndarray, "frames points 3"]) -> str:
    seen = is_seen(points)
    if seen.shape[1] < LEAST_POINTS or len(seen) < 2:
        return ""
    missing = 1 - float(seen.mean())
    changes = float((seen[1:] != seen[:-1]).mean())
    if not MISSING_SHARE <= missing <= NEARLY_ALL or changes < CHANCE_SHARE * 2 * missing * (1 - missing):
        return ""
    return f"{missing:.0%} of its points are missing, scattered as if it was read in the wrong places"
