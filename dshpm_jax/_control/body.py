"""What follows from a model and the settings alone; made once for all recordings of a subject."""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse.csgraph import connected_components

from dshpm_jax._control.counterparts import turns
from dshpm_jax._control.targets import make_targets, symmetries
from dshpm_jax._kernels.life_evidence import MIN_DISTANCES, MIRROR, UNKNOWN
from dshpm_jax._model import SubjectModel
from dshpm_jax._model import neighbourhood_arrays as as_arrays
from dshpm_jax._requests import Target
from dshpm_jax._settings import Settings
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH

PAIR_NOISE = 5.0  # mm, least deviation of a distance between two recordings
PAIR_RANGE = 700.0  # mm, a distance would be anything within it if the labels meant nothing
USUAL_LOSS = 5.2  # nats, by the shape of the t distribution
USUAL_LOSS_OF_DISTANCE = 1.8  # of its one-dimensional form, for each distance
KEPT = 64  # bodies in memory, each some hundred kilobytes


@dataclass(frozen=True, eq=False)
class Body:
    """A model as the control uses it.

    Attributes:
        targets: the segments as the matcher sees them.
    """

    model: SubjectModel
    settings: Settings
    targets: list[Target]

    def loosened(self, factor: float) -> "Body":
        """The same body with all tolerances multiplied."""
        targets = [
            replace(t, tolerance=t.tolerance * factor, scale=t.scale * factor, reach=t.reach * factor)
            for t in self.targets
        ]
        return Body(self.model, self.settings, targets)

    @cached_property
    def owned(self) -> Bool[np.ndarray, "segments markers+1"]:
        """Which markers each segment has; `NO_MATCH`, the last, belongs to none."""
        owned = np.zeros((len(self.targets), self.model.num_markers + 1), bool)
        for target in self.targets:
            owned[target.segment, target.markers] = True
        return owned

    @cached_property
    def neighbourhoods(self) -> tuple[np.ndarray, ...]:
        """The model's neighbourhoods as padded arrays.

        Raises:
            ValueError: the model has none.
        """
        if not self.model.neighbourhoods:
            raise ValueError(
                "the model has no neighbourhoods, which the method 'full' judges by; make it again with 'dshpm-jax "
                "model' or take the method 'paper'"
            )
        return as_arrays(self.model.neighbourhoods)

    @cached_property
    def pairs(self) -> tuple[np.ndarray, ...]:
        """For all pairs of markers: mean distance (mm), and what `posture` makes of the deviation.

        These are the inverse of its scale (1/mm) and the log ratio at the mean (nats); a pair without a known
        distance, such as one between two people, has 0 for both.
        """
        mean, spread = self.model.pair_mean, self.model.pair_spread
        known = np.isfinite(mean) & ~np.eye(len(mean), dtype=bool)
        mean = np.where(known, mean, 0.0)
        deviation = np.sqrt(
            np.where(known, spread, 0.0) ** 2 + (self.settings.tolerance_ratio * mean) ** 2 + PAIR_NOISE**2
        )
        inverse = np.where(known, 1.0 / (np.sqrt(3.0) * deviation), 0.0)
        peak = np.where(known, np.log(PAIR_RANGE / deviation), 0.0)
        return mean.astype(np.float32), inverse.astype(np.float32), peak.astype(np.float32)

    @cached_property
    def subjects(self) -> list[tuple[np.ndarray, ...]]:
        """For each subject its markers, between which distances are known, and its part of each table of `pairs`."""
        _, group = connected_components(np.isfinite(self.model.pair_mean), directed=False)
        markers = [np.flatnonzero(group == k) for k in range(group.max() + 1)]
        return [(own, *(table[np.ix_(own, own)] for table in self.pairs)) for own in markers]

    @cached_property
    def symmetries(self) -> list[list[tuple[int, ...]]]:
        """The ways to turn each segment onto itself."""
        return [symmetries(target) for target in self.targets]

    @cached_property
    def turns(self) -> list[Int[np.ndarray, " markers"]]:
        """What each marker becomes when chains of segments that are counterparts are exchanged, a row a way."""
        return turns(self.model.segments, self.targets, self.pairs[0])

    @cached_property
    def usual_evidence(self) -> Float[np.ndarray, " markers"]:
        """The evidence that a right label has on average (nats), by the spread of its marker's neighbourhood.

        The mean of the log ratio that `life_evidence` gives when the errors are distributed as it assumes; where the
        marker has too few neighbours for a pose, by its distances.
        """
        ids, _, _, softness, spread = self.neighbourhoods
        of_pose = 3.0 * np.log(np.sqrt(3.0) * PAIR_RANGE / spread) - USUAL_LOSS
        known = ids != NO_MATCH
        of_each = np.where(known, np.log(PAIR_RANGE / softness) - USUAL_LOSS_OF_DISTANCE, 0.0)
        of_distances, count = of_each.sum(1) - MIRROR, known.sum(1)
        return np.select([count >= MIN_FIT_POINTS, count >= MIN_DISTANCES], [of_pose, of_distances], UNKNOWN)

    @cached_property
    def partners(self) -> float:
        """With how many markers, itself included, a marker has a known distance, on average."""
        return max(1.0, float(np.isfinite(self.model.pair_mean).sum(1).mean()))


@lru_cache(maxsize=KEPT)
def body_of(model: SubjectModel, settings: Settings) -> Body:
    """The body of a model, which is told from others by its identity."""
    return Body(model, settings, make_targets(model, settings))
