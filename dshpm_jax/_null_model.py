"""What a place says where no marker is: the errors of a marker against a background; one source for all, without jax.

A marker misses its expected place by a t distribution, as soft tissue has heavy tails. A point that is no marker may be
anywhere within a body's volume. The logarithm of the ratio of the two densities, the log-likelihood ratio (nats), is
what labels are judged by: by the kernel `life_evidence`, and by the control that expects and sums such ratios.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.special import digamma


@dataclass(frozen=True)
class NullModel:
    """The numbers of the ratio. `Tuning` holds them, with what each is worth; hashable, so that kernels are compiled
    for it.

    Attributes:
        t_dof: degrees of freedom of the errors' t distribution.
        background_mm: within how much a point that is no marker may be anywhere, along each axis (mm).
        min_llr: least ratio of a point (nats).
        unknown_llr: the ratio where nothing speaks for the label or against it (nats).
        robust_rounds: reweighted fits of a marker's neighbours after the first.
        robust_scale: a neighbour that misses by this many of its standard deviations counts a quarter.
        max_pose_sd_ratio: from this many times the standard deviation of the second neighbour on, a pose is too vague.
        min_distances: fewer known neighbours say nothing.
        max_distances: of more known neighbours the most rigid count.
        min_weight_share: neighbours with less of the weight do not count as present.
        leverage_offset, few_neighbours_variance: how a prediction softens where neighbours are few or far, see
            `_kernels.life_evidence`.
    """

    t_dof: float
    background_mm: float
    min_llr: float
    unknown_llr: float
    robust_rounds: int
    robust_scale: float
    max_pose_sd_ratio: float
    min_distances: int
    max_distances: int
    min_weight_share: float
    leverage_offset: float
    few_neighbours_variance: float

    @property
    def reflection_penalty(self) -> float:
        """What distances alone lose, as they cannot tell a point from its mirror image (nats)."""
        return math.log(2.0)

    @property
    def fits_per_place(self) -> int:
        """Rigid fits behind each predicted place."""
        return 1 + self.robust_rounds


def llr_at_mean(null: NullModel, log_sd: Any, dimensions: int) -> Any:
    """The ratio (nats) of a point without any error.

    Arguments:
        log_sd: logarithm of the standard deviation along each axis (mm), a number or an array of numpy or jax.
        dimensions: of the error, 3 for a place and 1 for a distance.
    """
    dof = null.t_dof
    peak = math.lgamma((dof + dimensions) / 2) - math.lgamma(dof / 2) - 0.5 * dimensions * math.log(dof * math.pi)
    return peak + dimensions * (math.log(null.background_mm) - log_sd)


def expected_llr(
    null: NullModel, sd: Float[np.ndarray, "*any"] | Float[np.ndarray, ""], dimensions: int
) -> Float[np.ndarray, "*any"]:
    """The mean ratio (nats) of points whose errors are distributed as assumed.

    The logarithm of 1 + square / dof has the mean digamma((dof + dimensions) / 2) - digamma(dof / 2).

    Arguments:
        sd: standard deviation along each axis (mm).
        dimensions: see `llr_at_mean`.
    """
    half = (null.t_dof + dimensions) / 2
    loss = half * float(digamma(half) - digamma(null.t_dof / 2))
    return llr_at_mean(null, np.log(sd), dimensions) - loss
