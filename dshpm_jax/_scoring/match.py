"""Match scores: how badly a fitted hypothesis fits its segment (Eq. 4)."""

import abc

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float


class AbstractMatchScore(eqx.Module):
    """Cost of a fitted match; lower is better, and from 1 on its quality is not acceptable."""

    @abc.abstractmethod
    def __call__(
        self,
        residuals: Float[Array, " markers"],
        scale: Float[Array, " markers"],
        matched: Bool[Array, " markers"],
    ) -> Float[Array, ""]:
        """The cost of residuals (mm) of the `matched` markers; `scale` is the residual that Eq. 4 allows each (mm).

        Residuals of markers that are not matched are 0; at least three are matched.
        """


class MeanResidual(AbstractMatchScore):
    """Eq. 4 with the mean residual, the "average mapping error" of section 4.2.2."""

    def __call__(self, residuals, scale, matched):
        count = jnp.maximum(jnp.sum(matched, dtype=residuals.dtype), 1.0)
        return jnp.sum(jnp.where(matched, residuals / scale, 0.0)) / count


class RmsResidual(AbstractMatchScore):
    """Eq. 4 with the root mean square residual, which one bad marker raises more."""

    def __call__(self, residuals, scale, matched):
        count = jnp.maximum(jnp.sum(matched, dtype=residuals.dtype), 1.0)
        return jnp.sqrt(jnp.sum(jnp.where(matched, (residuals / scale) ** 2, 0.0)) / count)


class MaxResidual(AbstractMatchScore):
    """Eq. 4 with the largest residual: every marker has to fit."""

    def __call__(self, residuals, scale, matched):
        return jnp.max(jnp.where(matched, residuals / scale, 0.0))
