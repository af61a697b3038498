"""Match scores of fits that the host has made, compiled."""

import equinox as eqx
import jax
from jaxtyping import Array, Bool, Float

from dshpm_jax._scoring import AbstractMatchScore


@eqx.filter_jit
def score_matches(
    score: AbstractMatchScore,
    residuals: Float[Array, "fits columns"],
    scale: Float[Array, "fits columns"],
    matched: Bool[Array, "fits columns"],
) -> Float[Array, " fits"]:
    """The cost of each fit, a row of residuals (mm)."""
    return jax.vmap(score)(residuals, scale, matched)
