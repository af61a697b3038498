"""Poses of segments from identified markers, and what they predict."""

import numpy as np
from jaxtyping import Bool, Float

from dshpm_jax._requests import Control, FitPoses, ScoreMatch, Target
from dshpm_jax._types import MIN_FIT_POINTS


def fit_one(
    target: Target, points: Float[np.ndarray, "columns 3"], there: Bool[np.ndarray, " columns"]
) -> Control[tuple[np.ndarray, np.ndarray, bool]]:
    """The pose of `target` from the points that are there, as (predicted places, residuals, whether it is one).

    Residuals are mm, 0 where there is no point.
    """
    poses = yield FitPoses(target.shape[None], points[None], there[None].astype(float))
    predicted = target.shape @ poses.rotation[0].T + poses.translation[0]
    residual = np.where(there, np.linalg.norm(predicted - points, axis=1), 0.0)
    return predicted, residual, bool(there.sum() >= MIN_FIT_POINTS and poses.rank[0] >= 2)


def mapping_error(target: Target, residual: np.ndarray, there: np.ndarray) -> Control[float]:
    """Eq. 4 for a fit made on the host's request, by the match score in use; under 1 is good."""
    if not there.any():
        return np.inf
    return float((yield ScoreMatch(residual, target.scale, there)))
