"""How far to trust a learnt spread: a clip too short or too still says less than what bodies do in general.

A walk of a second leaves the shoulders where they are; the jump after it moves them by centimetres. So the spread of a
pair is its learnt one joined with a general one, each weighted by its time in motion.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from dshpm_jax._model_building.body_parts import meet, parts_of_each
from dshpm_jax._model_building.statistics import DistanceStatistics
from dshpm_jax._model_building.tuning import TUNING, ModelTuning


def expected_spread(
    statistics: DistanceStatistics, names: Sequence[str], tuning: ModelTuning = TUNING
) -> Float[np.ndarray, "markers markers"]:
    """Spread to be expected of every pair (mm): root of the weighted mean of learnt and general variance.

    A pair that no recording shows together has no distance, so its spread stays NaN.
    """
    general = general_spread(statistics, names, tuning)
    learnt = np.where(statistics.seconds > 0, statistics.spread, 0)
    variance = statistics.seconds * learnt**2 + tuning.general_seconds * general**2
    spread = np.sqrt(variance / (statistics.seconds + tuning.general_seconds))
    np.fill_diagonal(spread, 0)
    return spread


def general_spread(
    statistics: DistanceStatistics, names: Sequence[str], tuning: ModelTuning
) -> Float[np.ndarray, "markers markers"]:
    """Spread of every pair in general (mm), by what the names say and by the distance, NaN where that is unknown."""
    parts = parts_of_each(names)
    share = np.array([[_general_share(one, other, tuning) for other in parts] for one in parts])
    return np.hypot(tuning.general_mm, share * statistics.mean)


def _general_share(one: frozenset[str], other: frozenset[str], tuning: ModelTuning) -> float:
    """Spread of a pair as a share of its distance, by the parts of the body that the names of the two say."""
    if not one or not other:
        return tuning.general_unnamed
    common = one & other
    if not common:
        return tuning.general_across if any(meet(a, b) for a in one for b in other) else tuning.general_far
    joints = (len(one) > 1) + (len(other) > 1)
    if joints and any(part == "trunk" or part.endswith("upper arm") for part in common):
        return tuning.general_soft
    return tuning.general_at_joint if joints or "trunk" in common else tuning.general_one_part
