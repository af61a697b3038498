"""What is known of the distances of a new subject: the set's, drawn towards what trusted labels show."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from dshpm_jax._marker_set.marker_set import MarkerSet, pairs_of, squares
from dshpm_jax._marker_set.tuning import TUNING, SetTuning
from dshpm_jax._model import SubjectModel


@dataclass(frozen=True, eq=False)
class Posterior:
    """The log distances that a new subject is expected to have, and how far each may be off.

    Attributes:
        mean: log mean distance of each pair (mm), NaN where the set knows none.
        variance: of it, without what postures add.
        size: log size of the subject against the set's mean.
    """

    mean: Float[np.ndarray, "markers markers"]
    variance: Float[np.ndarray, "markers markers"]
    size: float


def prior_of(markers: MarkerSet, tuning: SetTuning = TUNING) -> Posterior:
    """What is expected of a subject of whom nothing is known."""
    return Posterior(markers.mean_log, markers.between_sd**2 + tuning.size_sd**2, 0.0)


def posture_variance(markers: MarkerSet, tuning: SetTuning = TUNING) -> Float[np.ndarray, "markers markers"]:
    """How far the mean distances of a recording may be off the subject's own, as variance of logarithms."""
    slack = tuning.posture_slack * np.minimum(1.0, markers.within / tuning.soft_pair)
    return markers.within**2 + slack**2 + (tuning.noise_mm / np.exp(markers.mean_log)) ** 2


def posterior_of(
    markers: MarkerSet, observed: Float[np.ndarray, "markers markers"], tuning: SetTuning = TUNING
) -> Posterior:
    """What is expected once log mean distances of some pairs are observed; NaN where none is.

    The size and the components are estimated from all of them together, and what is left pair by pair.
    """
    rows, columns = pairs_of(markers.num_markers)
    mean, between = markers.mean_log[rows, columns], markers.between_sd[rows, columns] ** 2
    factors = np.column_stack(
        [np.full(len(mean), tuning.size_sd), *(tuning.component_share * c[rows, columns] for c in markers.components)]
    )
    explained = tuning.explained_share * (factors[:, 1:] ** 2).sum(1)
    own = np.maximum(between - explained, tuning.least_own_share * between)
    value, noise = observed[rows, columns], posture_variance(markers, tuning)[rows, columns]
    seen = np.isfinite(value) & np.isfinite(mean)
    off, variance = (value - mean)[seen], (own + noise)[seen]
    counted = min(1.0, tuning.evidence_per_marker * markers.num_markers / max(1, seen.sum()))
    weighted = counted * factors[seen].T / variance
    covariance = np.linalg.inv(np.eye(factors.shape[1]) + weighted @ factors[seen])
    found = covariance @ (weighted @ off)
    expected = mean + factors @ found
    by_factors = np.einsum("ij,jk,ik->i", factors, covariance, factors)
    spread = by_factors + own
    drawn = own[seen] / variance
    expected[seen] += drawn * (value - expected)[seen]
    spread[seen] = drawn * noise[seen] + (1 - drawn) ** 2 * by_factors[seen]
    spread += tuning.posterior_floor**2
    count = markers.num_markers
    return Posterior(squares(expected, count), squares(spread, count), float(found[0] * tuning.size_sd))


def posterior_of_model(markers: MarkerSet, model: SubjectModel, tuning: SetTuning = TUNING) -> Posterior:
    """What is expected of a subject whose model was found before."""
    rows, columns = pairs_of(markers.num_markers)
    distance = model.pair_mean[rows, columns]
    known = np.isfinite(distance) & (distance > 0)
    log = np.where(known, np.log(np.where(known, distance, 1.0)), np.nan)
    return posterior_of(markers, squares(log, markers.num_markers, np.nan), tuning)
