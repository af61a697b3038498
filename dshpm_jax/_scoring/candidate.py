"""Candidate scores: how badly an observed distance to the pivot fits a model distance (Eq. 3)."""

import abc

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float


class AbstractCandidateScore(eqx.Module):
    """Cost of a candidate; lower is better, and above 1 it is no candidate.

    A subclass writes the scalar function; the library maps it over all pivots, columns and points, masks padding and
    compiles it.
    """

    @abc.abstractmethod
    def __call__(
        self,
        model_distance: Float[Array, ""],
        data_distance: Float[Array, ""],
        tolerance: Float[Array, ""],
    ) -> Float[Array, ""]:
        """The cost of taking a point `data_distance` from the assumed pivot for a marker that the model has at
        `model_distance`, with the `tolerance` of that pair (all mm)."""


class ToleranceScore(AbstractCandidateScore):
    """Eq. 3: the difference of the distances over what is allowed for the pair.

    Our reading: Eq. 3 allows a share of the distance, which vanishes for near markers; the tolerance has a floor
    (`Settings.measurement_noise`), and with a learnt model it is the learnt spread of the pair.
    """

    def __call__(self, model_distance, data_distance, tolerance):
        return jnp.abs(model_distance - data_distance) / tolerance


class GaussianCandidate(AbstractCandidateScore):
    """Negative log likelihood of the difference of the distances if it is normally distributed.

    In units of what a difference of one tolerance costs, so that the candidates of a column are those of Eq. 3; small
    differences cost next to nothing, and tables are ranked by the likelihood of all their columns together. Method
    "full" makes the tolerance of a pair from its learnt spread (`Settings.spread_factor`); the paper's is a share of
    the distance. What the likelihood takes for the width itself is the same for all candidates of a column, and is
    left out.
    """

    def __call__(self, model_distance, data_distance, tolerance):
        return ((model_distance - data_distance) / tolerance) ** 2
