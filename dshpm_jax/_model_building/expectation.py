"""How far to trust a learnt spread: a clip too short or too still says less than what bodies do in general.

A walk of a second leaves the shoulders where they are; the jump after it moves them by centimetres. So the spread of a
pair is its learnt one joined with a general one, each weighted by its time in motion.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from dshpm_jax._model_building.body_parts import meet, parts_of_each
from dshpm_jax._model_building.statistics import DistanceStatistics

GENERAL_MM = 2.0
"""Spread of any pair of markers on skin, whatever their distance."""

GENERAL_SHARE = {"one part": 0.01, "at a joint": 0.025, "soft": 0.05, "across": 0.10, "far": 0.20, "unnamed": 0.02}
"""Spread as a share of the distance, by what the names say: both on one part, one of them at its joint, on the trunk or
an upper arm with a shoulder, across a joint, further apart, or nothing known. Medians over public recordings of what
was seen in motions that the model's own recording did not have."""

GENERAL_SECONDS = 1.5
"""The general spread weighs as much as so many seconds of lively motion."""


def expected_spread(statistics: DistanceStatistics, names: Sequence[str]) -> Float[np.ndarray, "markers markers"]:
    """Spread to be expected of every pair (mm): root of the weighted mean of learnt and general variance.

    A pair that no recording shows together has no distance, so its spread stays NaN.
    """
    general = np.hypot(GENERAL_MM, general_share(names) * statistics.mean)
    learnt = np.where(statistics.seconds > 0, statistics.spread, 0)
    variance = statistics.seconds * learnt**2 + GENERAL_SECONDS * general**2
    spread = np.sqrt(variance / (statistics.seconds + GENERAL_SECONDS))
    np.fill_diagonal(spread, 0)
    return spread


def general_share(names: Sequence[str]) -> Float[np.ndarray, "markers markers"]:
    """`GENERAL_SHARE` of every pair of names."""
    parts = parts_of_each(names)
    return np.array([[GENERAL_SHARE[_kind(one, other)] for other in parts] for one in parts])


def _kind(one: frozenset[str], other: frozenset[str]) -> str:
    if not one or not other:
        return "unnamed"
    common = one & other
    if not common:
        return "across" if any(meet(a, b) for a in one for b in other) else "far"
    joints = (len(one) > 1) + (len(other) > 1)
    if joints and any(part == "trunk" or part.endswith("upper arm") for part in common):
        return "soft"
    return "at a joint" if joints or "trunk" in common else "one part"
