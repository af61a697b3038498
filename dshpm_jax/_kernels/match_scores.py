"""Match scores of fits that the host has made, compiled."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from dshpm_jax._scoring import AbstractMatchScore


@eqx.filter_jit
def score_matches(
    score: AbstractMatchScore,
    residuals: Float[np.ndarray, "fits columns"],
    scale: Float[np.ndarray, "fits columns"],
    matched: Bool[np.ndarray, "fits columns"],
) -> Float[Array, " fits"]:
    """The cost of each fit, a row of residuals (mm)."""
    return jax.vmap(score)(jnp.asarray(residuals), jnp.asarray(scale), jnp.asarray(matched))
