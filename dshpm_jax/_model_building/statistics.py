"""How the distance of every pair of markers behaves over the labelled recordings."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import evenly_spaced, is_seen
from dshpm_jax._model_building.tuning import TUNING, ModelTuning


@dataclass(frozen=True, eq=False)
class DistanceStatistics:
    """Pair distances in millimetres, NaN for pairs never seen together; symmetric, the diagonal is zero.

    `evidence` says how much of the motion a pair has seen: 1 if it was there all the time in the liveliest recording,
    near 0 if it was only ever seen standing still or in a few frames. `seconds` is its time in lively motion.
    """

    mean: Float[np.ndarray, "markers markers"]
    spread: Float[np.ndarray, "markers markers"]
    evidence: Float[np.ndarray, "markers markers"]
    seconds: Float[np.ndarray, "markers markers"]


def pair_statistics(
    clips: Sequence[Float[np.ndarray, "frames markers 3"]], rates: Sequence[float], tuning: ModelTuning = TUNING
) -> DistanceStatistics:
    """Mean and spread of all pair distances, pooled over recordings.

    A recording counts by how much it moves, so the spread is that of motion; where recordings disagree about a mean
    (a marker was moved between them), the disagreement is part of the spread.

    Arguments:
        clips: the markers of the model in each recording, mm, NaN where missing.
        rates: frames a second of each recording.
    """
    markers = clips[0].shape[1]
    rows, columns = np.triu_indices(markers, 1)
    parts = [_one_recording(clip, rows, columns, tuning) for clip in clips]
    count, mean, variance = (np.stack(values) for values in zip(*parts))
    moved = _typical_spread(variance, tuning)
    lively = np.maximum(moved / max(moved.max(), 1e-9), tuning.still_weight)
    weight = lively[:, None] * count / (count + tuning.few_frames)
    total = np.maximum(weight.sum(0), np.finfo(float).tiny)
    seen = count.sum(0) > 0
    pooled = np.where(seen, (weight * np.where(count > 0, mean, 0)).sum(0) / total, np.nan)
    around = np.where(count > 0, variance + (mean - pooled) ** 2, 0)
    spread = np.where(seen, np.sqrt((weight * around).sum(0) / total), np.nan)

    def square(values: np.ndarray, diagonal: float) -> np.ndarray:
        full = np.full((markers, markers), diagonal, dtype=values.dtype)
        full[rows, columns] = full[columns, rows] = values
        return full

    seconds = (count / np.asarray(rates)[:, None] * np.minimum(moved / tuning.lively_mm, 1)[:, None]).sum(0)
    return DistanceStatistics(
        mean=square(pooled, 0.0),
        spread=square(spread, 0.0),
        evidence=square(np.minimum(weight.sum(0), 1.0), 1.0),
        seconds=square(seconds, 0.0),
    )


def liveliness(clip: Float[np.ndarray, "frames markers 3"], tuning: ModelTuning = TUNING) -> float:
    """How much the subject moves in one recording (mm): a high quantile of the spreads of the pairs that it shows."""
    rows, columns = np.triu_indices(clip.shape[1], 1)
    count, _, variance = _one_recording(clip, rows, columns, tuning)
    shown = variance[count > 0]
    return float(np.quantile(np.sqrt(shown), tuning.typical_quantile)) if len(shown) else 0.0


def _one_recording(
    clip: np.ndarray, rows: np.ndarray, columns: np.ndarray, tuning: ModelTuning
) -> tuple[np.ndarray, ...]:
    """Common frames, trimmed mean and trimmed variance of each pair in one recording."""
    seen = is_seen(clip)
    together = (seen[:, rows] & seen[:, columns]).sum(0)
    clip = clip[evenly_spaced(len(clip), tuning.max_frames, rounded=True)]
    distance = np.sort(np.linalg.norm(clip[:, rows] - clip[:, columns], axis=-1), axis=0)  # NaN last
    count = np.isfinite(distance).sum(0)
    cut = (tuning.trimmed_share * count).astype(int)
    place = np.arange(len(distance))[:, None]
    kept = (place >= cut) & (place < count - cut)
    n = np.maximum(kept.sum(0), 1)
    values = np.where(kept, distance, 0)
    mean = values.sum(0) / n
    variance = (np.where(kept, distance - mean, 0) ** 2).sum(0) / n
    return np.where(count > 0, together, 0), mean, variance


def _typical_spread(
    variance: Float[np.ndarray, "recordings pairs"], tuning: ModelTuning
) -> Float[np.ndarray, "recordings"]:
    """A high quantile of the spreads of the pairs in each recording (mm): how much the subject moves."""
    if variance.shape[1] == 0:
        return np.ones(len(variance))
    return np.quantile(np.sqrt(variance), tuning.typical_quantile, axis=1)
