"""What follows from a model, the settings and the tuning alone; made once for all recordings of a subject."""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import combinations

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse.csgraph import connected_components

from dshpm_jax._control.counterparts import side_permutations
from dshpm_jax._control.targets import make_targets, symmetries
from dshpm_jax._control.tuning import Tuning
from dshpm_jax._model import SubjectModel, neighbourhood_arrays
from dshpm_jax._null_model import NullModel, expected_llr
from dshpm_jax._requests import Target
from dshpm_jax._settings import Settings
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH

MODELS_KEPT = 64  # prepared models in memory, each some hundred kilobytes


@dataclass(frozen=True, eq=False)
class PreparedModel:
    """A model as the control uses it.

    Attributes:
        targets: the segments as the matcher sees them.
    """

    model: SubjectModel
    settings: Settings
    tuning: Tuning
    targets: list[Target]

    def loosened(self, factor: float) -> "PreparedModel":
        """The same model with all tolerances multiplied."""
        targets = [
            replace(t, tolerance=t.tolerance * factor, scale=t.scale * factor, reach=t.reach * factor)
            for t in self.targets
        ]
        return replace(self, targets=targets)

    @cached_property
    def null(self) -> NullModel:
        """The densities that evidence compares."""
        return self.tuning.null_model

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
        return neighbourhood_arrays(self.model.neighbourhoods)

    @cached_property
    def pairs(self) -> tuple[np.ndarray, ...]:
        """For all pairs of markers: mean distance (mm), and what `distance_llr` makes of the deviation.

        These are the inverse of its scale (1/mm) and the ratio at the mean, up to the constant of the t density
        (nats); a pair without a known distance, such as one between two people, has 0 for both.
        """
        mean, spread = self.model.pair_mean, self.model.pair_spread
        known = np.isfinite(mean) & ~np.eye(len(mean), dtype=bool)
        mean = np.where(known, mean, 0.0)
        sd = np.sqrt(
            np.where(known, spread, 0.0) ** 2
            + (self.settings.tolerance_ratio * mean) ** 2
            + self.tuning.pair_noise_mm**2
        )
        inverse = np.where(known, 1.0 / (np.sqrt(self.null.t_dof) * sd), 0.0)
        peak = np.where(known, np.log(self.null.background_mm / sd), 0.0)
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
        return [symmetries(target, self.tuning) for target in self.targets]

    @cached_property
    def clusters(self) -> list[Int[np.ndarray, " cluster"]]:
        """Small sets of markers near each other, ascending: each with those nearest to it, and each small segment."""
        apart = np.where(np.isfinite(self.model.pair_mean), self.model.pair_mean, np.inf)
        near = np.argsort(apart, axis=1, kind="stable")[:, : self.tuning.cluster_size]
        sets = [row[np.isfinite(apart[m, row])] for m, row in enumerate(near)]
        sets += [t.markers for t in self.targets if len(t.markers) <= self.tuning.max_symmetric_markers]
        distinct = {tuple(sorted(one.tolist())) for one in sets if len(one) > 1}
        return [np.array(one) for one in sorted(distinct)]

    @cached_property
    def near_pairs(self) -> Int[np.ndarray, "pairs 2"]:
        """Every two markers that share a cluster, ascending."""
        pairs = {pair for cluster in self.clusters for pair in combinations(cluster.tolist(), 2)}
        return np.array(sorted(pairs), dtype=int).reshape(-1, 2)

    @cached_property
    def side_permutations(self) -> list[Int[np.ndarray, " markers"]]:
        """What each marker becomes when chains of segments that are counterparts are exchanged, a row a way."""
        return side_permutations(self.model.segments, self.targets, self.pairs[0], self.tuning)

    @cached_property
    def expected_llr(self) -> Float[np.ndarray, " markers"]:
        """The evidence that a right label has on average (nats), by the standard deviation of its neighbourhood.

        Where the marker has too few neighbours for a pose, by its distances.
        """
        ids, _, _, distance_sd, marker_sd = self.neighbourhoods
        by_pose = expected_llr(self.null, marker_sd / np.sqrt(3.0), 3)
        known = ids != NO_MATCH
        by_each = np.where(known, expected_llr(self.null, distance_sd, 1), 0.0)
        by_distances, count = by_each.sum(1) - self.null.reflection_penalty, known.sum(1)
        posed, judged = count >= MIN_FIT_POINTS, count >= self.null.min_distances
        return np.select([posed, judged], [by_pose, by_distances], self.null.unknown_llr)

    @cached_property
    def usual_gain(self) -> Float[np.ndarray, " markers"]:
        """What a right label usually pays in a frame (nats)."""
        return np.maximum(self.expected_llr - self.tuning.accept_llr, self.tuning.min_usual_gain)

    @cached_property
    def partners(self) -> float:
        """With how many markers, itself included, a marker has a known distance, on average."""
        return max(1.0, float(np.isfinite(self.model.pair_mean).sum(1).mean()))


@lru_cache(maxsize=MODELS_KEPT)
def prepared(model: SubjectModel, settings: Settings, tuning: Tuning) -> PreparedModel:
    """The prepared model; a `SubjectModel` is told from others by its identity."""
    return PreparedModel(model, settings, tuning, make_targets(model, settings, tuning))
