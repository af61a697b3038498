"""How the distance of every pair of markers behaves over the labelled recordings."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

MAX_FRAMES = 1000
"""Frames taken from one recording, evenly spaced: more say nothing new about a distance."""

TRIM = 0.01
"""Share of a pair's frames left out on each side: hand labels are wrong in a few frames of many public files."""

FEW_FRAMES = 20
"""A pair seen in so many frames of a recording counts half as much as one that is always seen."""

STILL_WEIGHT = 0.1
"""Least weight of a recording, relative to the liveliest: a long static must not drown a short clip of motion."""


@dataclass(frozen=True, eq=False)
class PairStatistics:
    """Pair distances in millimetres, NaN for pairs never seen together; symmetric, the diagonal is zero."""

    mean: Float[np.ndarray, "markers markers"]
    spread: Float[np.ndarray, "markers markers"]
    low: Float[np.ndarray, "markers markers"]
    high: Float[np.ndarray, "markers markers"]
    frames: Int[np.ndarray, "markers markers"]


def pair_statistics(clips: Sequence[Float[np.ndarray, "frames markers 3"]]) -> PairStatistics:
    """Mean, spread and range of all pair distances, pooled over recordings.

    A recording counts by how much it moves, so the spread is that of motion; where recordings disagree about a mean
    (a marker was moved between them), the disagreement is part of the spread.

    Arguments:
        clips: the markers of the model in each recording, mm, NaN where missing.
    """
    markers = clips[0].shape[1]
    rows, columns = np.triu_indices(markers, 1)
    parts = [_one_recording(clip, rows, columns) for clip in clips]
    count, mean, variance, low, high = (np.stack(values) for values in zip(*parts))
    lively = _liveliness(variance)
    weight = lively[:, None] * count / (count + FEW_FRAMES)
    total = np.maximum(weight.sum(0), np.finfo(float).tiny)
    seen = count.sum(0) > 0
    pooled = np.where(seen, (weight * np.where(count > 0, mean, 0)).sum(0) / total, np.nan)
    around = np.where(count > 0, variance + (mean - pooled) ** 2, 0)
    spread = np.where(seen, np.sqrt((weight * around).sum(0) / total), np.nan)
    low = np.where(seen, np.where(count > 0, low, np.inf).min(0), np.nan)
    high = np.where(seen, np.where(count > 0, high, -np.inf).max(0), np.nan)

    def square(values: np.ndarray, diagonal: float) -> np.ndarray:
        full = np.full((markers, markers), diagonal, dtype=values.dtype)
        full[rows, columns] = full[columns, rows] = values
        return full

    frames = square(count.sum(0), 0)
    np.fill_diagonal(frames, sum(np.isfinite(clip).all(-1).sum(0) for clip in clips))
    return PairStatistics(square(pooled, 0.0), square(spread, 0.0), square(low, 0.0), square(high, 0.0), frames)


def _one_recording(clip: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, ...]:
    """Common frames, trimmed mean, trimmed variance, low and high of each pair in one recording."""
    seen = np.isfinite(clip.sum(-1))
    together = (seen[:, rows] & seen[:, columns]).sum(0)
    clip = clip[_even(len(clip))]
    distance = np.sort(np.linalg.norm(clip[:, rows] - clip[:, columns], axis=-1), axis=0)  # NaN last
    count = np.isfinite(distance).sum(0)
    cut = (TRIM * count).astype(int)
    place = np.arange(len(distance))[:, None]
    kept = (place >= cut) & (place < count - cut)
    n = np.maximum(kept.sum(0), 1)
    values = np.where(kept, distance, 0)
    mean = values.sum(0) / n
    variance = (np.where(kept, distance - mean, 0) ** 2).sum(0) / n
    low = np.where(kept, distance, np.inf).min(0)
    high = np.where(kept, distance, -np.inf).max(0)
    return np.where(count > 0, together, 0), mean, variance, low, high


def _even(frames: int) -> np.ndarray:
    return np.unique(np.linspace(0, frames - 1, min(frames, MAX_FRAMES)).round().astype(int))


def _liveliness(variance: Float[np.ndarray, "recordings pairs"]) -> Float[np.ndarray, "recordings"]:
    """Typical spread of the livelier half of the pairs in each recording, relative to the liveliest recording."""
    if variance.shape[1] == 0:
        return np.ones(len(variance))
    moved = np.quantile(np.sqrt(variance), 0.75, axis=1)
    return np.maximum(moved / max(moved.max(), 1e-9), STILL_WEIGHT)
