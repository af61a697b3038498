"""Looks at what a score returns before it is compiled into a kernel, and names the culprit."""

import jax
import jax.numpy as jnp
import numpy as np

from dshpm_jax._scoring.candidate import AbstractCandidateScore
from dshpm_jax._scoring.match import AbstractMatchScore

DISTANCES = np.array([0.0, 1.0, 30.0, 400.0, 2000.0], np.float32)  # mm
TOLERANCES = np.array([0.5, 5.0, 100.0], np.float32)  # mm


def check_candidate_score(score: AbstractCandidateScore) -> None:
    """Raises ValueError if `score` is NaN anywhere among plausible distances and tolerances."""
    grid = [jnp.asarray(x.ravel()) for x in np.meshgrid(DISTANCES, DISTANCES, TOLERANCES)]
    _refuse_nan(score, np.asarray(jax.vmap(score)(*grid)))


def check_match_score(score: AbstractMatchScore) -> None:
    """Raises ValueError if `score` is NaN for perfect, fair or hopeless residuals of three matched markers of four."""
    matched = jnp.array([True, True, False, True])
    residuals = jnp.asarray(DISTANCES)[:, None] * matched.astype(jnp.float32)[None]
    scale = jnp.broadcast_to(jnp.float32(5.0), residuals.shape)
    _refuse_nan(score, np.asarray(jax.vmap(score, in_axes=(0, 0, None))(residuals, scale, matched)))


def _refuse_nan(score, values: np.ndarray) -> None:
    if np.isnan(values).any():
        raise ValueError(
            f"{type(score).__name__} returned NaN; a score must return a number for every finite distance and residual"
        )
