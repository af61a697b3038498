"""Match scores: how badly a fitted hypothesis fits its segment (Eq. 4)."""

import abc

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float


class AbstractMatchScore(eqx.Module):
    """Cost of a fitted match; lower is better, and from 1 on its quality is not acceptable.

    A subclass writes the function for one match; the library maps it over all hypotheses and compiles it. It decides in
    the iterative match (section 4.2.2) and in motion verification (section 4.3.1).
    """

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


class GaussianMatch(AbstractMatchScore):
    """Negative log likelihood of the residuals if they are normally distributed, per marker.

    In units of what residuals cost that are all as large as Eq. 4 allows. The same matches are acceptable as with
    `RmsResidual`, but a lost marker is dearer against good residuals. The width is `scale`, which method "full" makes
    from the learnt spreads of the marker's distances.
    """

    def __call__(self, residuals, scale, matched):
        count = jnp.maximum(jnp.sum(matched, dtype=residuals.dtype), 1.0)
        return jnp.sum(jnp.where(matched, (residuals / scale) ** 2, 0.0)) / count


class RobustResidual(AbstractMatchScore):
    """The typical residual, whatever one bad marker says: the centre of a robust fit to the relative residuals.

    The fit is the fixed point of reweighting with the pseudo-Huber loss (optimistix), which never lets a larger
    residual cost less, as a loss that forgets bad markers would.

    Arguments:
        width: residuals this far from the centre, as a share of what Eq. 4 allows, begin to count less.
    """

    width: Float[Array, ""] = eqx.field(converter=jnp.asarray, default=0.3)

    def __call__(self, residuals, scale, matched):
        import optimistix  # takes a fifth of a second, which who uses no such score need not wait

        relative = jnp.where(matched, residuals / scale, 0.0)
        one = jnp.ones((), relative.dtype)

        def centre(guess, _):
            apart = (relative - guess) / jnp.asarray(self.width, relative.dtype)
            weight = jnp.where(matched, one / jnp.sqrt(one + apart**2), 0.0)
            return jnp.sum(weight * relative) / jnp.maximum(jnp.sum(weight), 1e-6)

        start = jnp.sum(relative) / jnp.maximum(jnp.sum(matched, dtype=relative.dtype), one)
        solver = optimistix.FixedPointIteration(rtol=1e-5, atol=1e-6)
        return optimistix.fixed_point(centre, solver, start, max_steps=64, throw=False).value
