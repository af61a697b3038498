"""What a distance says of two markers, as tables over nodes of log distance and log spread."""

import numpy as np
from jaxtyping import Float

from dshpm_jax._control.unseen.moments import Moment
from dshpm_jax._marker_set.marker_set import MarkerSet, pairs_of
from dshpm_jax._marker_set.posterior import Posterior, posture_variance
from dshpm_jax._marker_set.tuning import SetTuning
from dshpm_jax._requests import PairTable

LENGTH_NODES = np.linspace(np.log(10.0), np.log(3000.0), 64)
SPREAD_NODES = np.linspace(np.log(1.5), np.log(600.0), 16)
"""log mm; nodes of tables: a step is less than what any pair may be off."""

ALIKE = -6.0
"""nats; used in `score_table`: what two points of one marker cost; by hand: as much as a pair can gain."""


def score_table(markers: MarkerSet, known: Posterior, tuning: SetTuning) -> Float[np.ndarray, "markers nodes markers"]:
    """The log-likelihood ratio of each pair of markers at each node (nats), 0 for pairs that nobody has shown."""
    rows, columns = pairs_of(markers.num_markers)
    sd = np.sqrt(known.variance + posture_variance(markers, tuning))
    middle = float(np.nanmean(markers.mean_log[rows, columns]))
    length = _ratio(LENGTH_NODES, known.mean, sd, middle, tuning.background_sd, tuning)
    spreads = markers.spread_log[rows, columns]
    wide = float(np.nanstd(spreads)) + BROADER
    spread = _ratio(SPREAD_NODES, markers.spread_log, markers.spread_sd, float(np.nanmean(spreads)), wide, tuning)
    np.einsum("ana->an", length)[...] = ALIKE
    np.einsum("ana->an", spread)[...] = 0.0
    return np.concatenate([length, tuning.spread_weight * spread], axis=1)


BROADER = 0.3
"""log mm; used in `score_table`: spreads of a new recording vary by this more than those of the set; by hand."""


def _ratio(
    nodes: np.ndarray, mean: np.ndarray, sd: np.ndarray, middle: float, wide: float, tuning: SetTuning
) -> Float[np.ndarray, "markers nodes markers"]:
    """Density of a t distribution about the mean of each pair over a normal one about the middle of all."""
    sd = np.where(sd > 0, sd, 1.0)[:, None]  # the diagonal is no pair
    off = (nodes[:, None] - mean[:, None]) / sd
    ratio = -0.5 * (tuning.pair_dof + 1) * np.log1p(off**2 / tuning.pair_dof) - np.log(sd)
    ratio += (0.5 * ((nodes - middle) / wide) ** 2 + np.log(wide))[:, None]
    return np.nan_to_num(np.clip(ratio, tuning.min_pair_llr, tuning.max_pair_llr), nan=0.0).astype(np.float32)


def pair_table(moment: Moment, table: Float[np.ndarray, "markers nodes markers"], tuning: SetTuning) -> PairTable:
    """The table, and where the pairs of points of a moment are in it."""
    known = np.isfinite(moment.mean)
    np.fill_diagonal(known, False)
    length = np.log(np.maximum(np.where(known, moment.mean, 1.0), 1.0))
    spread = np.log(np.where(known, moment.spread, 0.0) + tuning.spread_floor_mm)
    near = [_corners(length, LENGTH_NODES, 0), _corners(spread, SPREAD_NODES, len(LENGTH_NODES))]
    node = np.concatenate([one[0] for one in near], axis=-1)
    weight = np.concatenate([one[1] for one in near], axis=-1) * known[..., None]
    partners = min(len(moment.alive), len(table)) - 1
    return PairTable(table, node, weight.astype(np.float32), tuning.unlabelled_llr * partners)


def _corners(value: np.ndarray, nodes: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray]:
    """The two nodes beside each value, and their weights."""
    place = np.clip((value - nodes[0]) / (nodes[1] - nodes[0]), 0.0, len(nodes) - 1.0)
    low = np.minimum(place.astype(int), len(nodes) - 2)
    share = place - low
    return np.stack([low, low + 1], axis=-1) + first, np.stack([1.0 - share, share], axis=-1)
