"""Looks at what a score returns before it is compiled into a kernel, and names the culprit."""

import jax
import jax.numpy as jnp
import numpy as np

from dshpm_jax._scoring.candidate import AbstractCandidateScore
from dshpm_jax._scoring.match import AbstractMatchScore

DISTANCES = np.array([0.0, 1.0, 30.0, 400.0, 2000.0], np.float32)  # mm
TOLERANCES = np.array([0.5, 5.0, 100.0], np.float32)  # mm


def check_candidate_score(score: AbstractCandidateScore) -> None:
    """Raises ValueError if `score` fails or is no number anywhere among plausible distances and tolerances."""
    grid = [jnp.asarray(x.ravel()) for x in np.meshgrid(DISTANCES, DISTANCES, TOLERANCES)]
    _refuse(score, jax.vmap(score), grid)


def check_match_score(score: AbstractMatchScore) -> None:
    """Raises ValueError if `score` fails, or is no number for perfect, fair or hopeless residuals of 3 markers of 4."""
    matched = jnp.array([True, True, False, True])
    residuals = jnp.asarray(DISTANCES)[:, None] * matched.astype(jnp.float32)[None]
    scale = jnp.broadcast_to(jnp.float32(5.0), residuals.shape)
    _refuse(score, jax.vmap(score, in_axes=(0, 0, None)), [residuals, scale, matched])


def _refuse(score, mapped, arguments: list) -> None:
    """Calls `mapped` as the kernels will, and says what is wrong with the score by its name."""
    name = type(score).__name__
    try:
        costs = jax.jit(mapped)(*arguments)
    except Exception as error:  # whatever a researcher's function may raise
        what = str(error).strip().splitlines()
        raise ValueError(
            f"{name} failed with {type(error).__name__}: {what[0] if what else ''} It is compiled by JAX and gets one "
            "hypothesis at a time: use jax.numpy instead of numpy, and jnp.where instead of if"
        ) from error
    shape = getattr(costs, "shape", None)
    if shape != arguments[0].shape[:1]:
        found = "no number" if shape is None else f"an array of shape {shape[1:]}"
        raise ValueError(f"{name} returned {found}; a score must return one number, such as jnp.sum(...) of an array")
    if not jnp.issubdtype(costs.dtype, jnp.floating):
        raise ValueError(f"{name} returned {costs.dtype}; a score must return a floating-point number")
    if np.isnan(np.asarray(costs)).any():
        raise ValueError(f"{name} returned NaN; a score must return a number for every finite distance and residual")
