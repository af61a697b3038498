"""What a labelling of a moment is worth by the population: pairs and signed volumes, in nats."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.unseen.moments import Moment
from dshpm_jax._marker_set.marker_set import MarkerSet
from dshpm_jax._marker_set.tuning import SetTuning
from dshpm_jax._requests import Control, PairTable, SignedVolumes
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True, eq=False)
class Handed:
    """What a set says besides tables: its fours as arrays, and which markers are near each other.

    Attributes:
        near: each marker and those nearest to it, a row each.
    """

    fours: Int[np.ndarray, "fours 4"]
    mean: Float[np.ndarray, " fours"]
    sd: Float[np.ndarray, " fours"]
    near: Int[np.ndarray, "markers near"]

    @classmethod
    def of(cls, markers: MarkerSet, tuning: SetTuning) -> "Handed":
        fours = markers.fours
        ids = np.array([four.markers for four in fours], np.int32).reshape(-1, 4)
        apart = np.where(np.isfinite(markers.mean_log), markers.mean_log, np.inf)
        np.fill_diagonal(apart, -np.inf)
        near = np.argsort(apart, axis=1, kind="stable")[:, : tuning.rebuilt_markers]
        return cls(ids, np.array([four.mean for four in fours]), np.array([four.sd for four in fours]), near)


@dataclass(frozen=True, eq=False)
class Judge:
    """Judges labellings of one moment.

    Attributes:
        moment: whose points are labelled.
        pairs: what their distances say.
        handed: what signed volumes say.
    """

    moment: Moment
    pairs: PairTable
    handed: Handed
    tuning: SetTuning

    @property
    def temper(self) -> float:
        """What a nat of all pairs counts: a marker has as many as there are others, most of which say the same."""
        per_marker = self.tuning.pairs_per_marker
        return min(1.0, per_marker / max(per_marker, len(self.pairs.table)))

    def total(self, labels: Int[np.ndarray, " points"]) -> float:
        """What all pairs say together."""
        labelled = np.flatnonzero(labels != NO_MATCH)
        own = labels[labelled]
        some = np.ix_(labelled, labelled)
        score = self.pairs.table[own[:, None, None], self.pairs.node[some], own[None, :, None]]
        unlabelled = (len(labels) - len(labelled)) * self.pairs.unlabelled
        return 0.5 * float((score * self.pairs.weight[some]).sum()) + unlabelled

    def volumes(self, labels: Int[np.ndarray, "labellings points"]) -> Control[Float[np.ndarray, " labellings"]]:
        """What signed volumes say of each labelling."""
        t = self.tuning
        numbers = t.volume_dof, t.volume_background, t.max_volume_llr
        handed = self.handed
        asked = SignedVolumes(self.moment.places, labels, handed.fours, handed.mean, handed.sd, numbers)
        return (yield asked).sum(1)

    def values(
        self, labels: Int[np.ndarray, "labellings points"], totals: Float[np.ndarray, " labellings"] | None = None
    ) -> Control[Float[np.ndarray, " labellings"]]:
        """What each labelling is worth; `totals` where they are known."""
        if totals is None:
            totals = np.array([self.total(one) for one in labels])
        volumes = yield from self.volumes(labels)
        return self.temper * totals + volumes
