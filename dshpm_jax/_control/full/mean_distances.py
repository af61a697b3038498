"""How far trajectories are from each other over the whole recording, and what that says of labels.

A pair of markers that hardly moves in this recording has a mean distance that is known to a few millimetres, however
soft the model's recordings were. So it tells which of several near markers is which, or that a limb is turned about its
long axis, where a single frame does not.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.pair_sums import PairSums
from dshpm_jax._control.tuning import Tuning
from dshpm_jax._types import NO_MATCH


class MeanDistances(NamedTuple):
    """Of pairs of markers as they are labelled, over the sampled frames.

    Attributes:
        share: of the frames, in how many both are labelled.
        mean, sd: of the distance in these (mm), 0 where there are none.
    """

    share: Float[np.ndarray, "*pairs"]
    mean: Float[np.ndarray, "*pairs"]
    sd: Float[np.ndarray, "*pairs"]


def label_sums(
    sums: PairSums, identity: Int[np.ndarray, " trajectories"], markers: int
) -> Float[np.ndarray, "3 markers markers"]:
    """The sums of `PairSums` for each two markers as they are labelled."""
    one, other = identity[sums.one], identity[sums.other]
    named = (one != NO_MATCH) & (other != NO_MATCH) & (one != other)
    code = one[named] * markers + other[named]
    return np.stack([np.bincount(code, each[named], markers**2) for each in sums.sums]).reshape(3, markers, markers)


def mean_distances(table: Float[np.ndarray, "3 *pairs"], frames: int) -> MeanDistances:
    """What these sums over so many sampled frames amount to."""
    count, total, square = table
    mean = total / np.maximum(count, 1)
    variance = np.maximum(square / np.maximum(count, 1) - mean**2, 0.0)
    return MeanDistances(count / max(frames, 1), mean, np.sqrt(variance))


def mean_llr(
    tuning: Tuning, found: MeanDistances, mean: Float[np.ndarray, "*pairs"], sd: Float[np.ndarray, "*pairs"]
) -> Float[np.ndarray, "*pairs"]:
    """The log-likelihood ratio of mean distances (nats), 0 where the model knows none.

    A pair is trusted as far as it keeps still in the model's recordings or in this one.

    Arguments:
        found: the distances of pairs as they are labelled.
        mean, sd: those of the model (mm), NaN where it knows none.
    """
    known = np.isfinite(mean)
    mean, sd = np.where(known, mean, 0.0), np.where(known, sd, 0.0)
    sd = np.sqrt(np.minimum(found.sd, sd) ** 2 + tuning.mean_noise_mm**2 + (tuning.mean_share * mean) ** 2)
    miss = np.log1p(((found.mean - mean) / sd) ** 2 / tuning.t_dof)
    ratio = np.log(tuning.background_mm / sd) - 0.5 * (tuning.t_dof + 1) * miss
    return np.where(known, np.maximum(ratio, tuning.min_mean_llr), 0.0)
