"""How the distances of a marker set differ between subjects: size, mean, variance and principal components."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from dshpm_jax._marker_set.tuning import SetTuning
from dshpm_jax._model_building.statistics import DistanceStatistics

_Pairs = Float[np.ndarray, " pairs"]


@dataclass(frozen=True, eq=False)
class Between:
    """What `MarkerSet` holds of pairs, each pair once, and what is left of each subject's log distances."""

    sizes: Float[np.ndarray, " subjects"]
    mean_log: _Pairs
    between_sd: _Pairs
    within: _Pairs
    spread_log: _Pairs
    spread_sd: _Pairs
    components: Float[np.ndarray, "components pairs"]
    rest: Float[np.ndarray, "subjects pairs"]


def between_subjects(each: Sequence[DistanceStatistics], tuning: SetTuning) -> Between:
    """What the pair statistics of several subjects have in common; NaN where a subject does not show a pair."""
    rows, columns = np.triu_indices(len(each[0].mean), 1)
    mean = np.maximum(np.stack([one.mean[rows, columns] for one in each]), 1.0)
    spread = np.stack([one.spread[rows, columns] for one in each])
    within = _median(spread / mean)
    log = np.log(mean)
    rigid = within <= np.nanquantile(within, tuning.rigid_share)
    sizes, mean_log = _sizes(log, rigid, tuning)
    rest = log - sizes[:, None] - mean_log
    count = np.isfinite(log).sum(0)
    variance = _variance(rest, count, within, tuning)
    logs = np.log(spread / np.exp(sizes)[:, None] + tuning.spread_floor_mm)
    return Between(
        sizes,
        mean_log,
        np.sqrt(variance),
        within,
        _mean(logs),
        np.sqrt(np.maximum(_mean((logs - _mean(logs)) ** 2), MIN_SPREAD_VARIANCE) + MOTION_VARIANCE),
        _components(rest, tuning),
        rest,
    )


MIN_SPREAD_VARIANCE, MOTION_VARIANCE = 0.15, 0.25
"""squared logarithms; used in `between_subjects`: variance of a log spread between subjects at least, and of how much a
new recording moves; by hand."""


def _sizes(log: np.ndarray, rigid: np.ndarray, tuning: SetTuning) -> tuple[np.ndarray, np.ndarray]:
    """Log size of each subject, and the mean log distance of pairs less size."""
    sizes = np.zeros(len(log))
    for _ in range(tuning.size_rounds):
        mean = _mean(log - sizes[:, None])
        sizes = _median((log - mean)[:, rigid].T)
        sizes = np.where(np.isfinite(sizes), sizes, 0.0)
        sizes -= sizes.mean()
    return sizes, _mean(log - sizes[:, None])


def _variance(rest: np.ndarray, count: np.ndarray, within: np.ndarray, tuning: SetTuning) -> _Pairs:
    """The variance that a further subject has, drawn towards pairs of like softness."""
    if len(rest) < 2:
        return np.full(rest.shape[1], tuning.lone_between**2) * 2.0
    own = np.nansum(rest**2, axis=0) / np.maximum(count - 1, 1)
    own = np.where(count > 1, own, np.nan)
    order = np.argsort(np.argsort(np.nan_to_num(within, nan=np.inf), kind="stable"), kind="stable")
    kind = order * tuning.softness_classes // max(len(within), 1)
    like = np.array([_median(own[kind == k]) for k in range(tuning.softness_classes)])
    like = np.where(np.isfinite(like), like, tuning.lone_between**2)[kind] + tuning.least_between**2
    weight = np.maximum(count - 1, 0)
    pooled = (weight * np.nan_to_num(own) + tuning.pool_subjects * like) / (weight + tuning.pool_subjects)
    known = np.maximum(count, 1)
    return pooled * (known + 1) / known


def _components(rest: np.ndarray, tuning: SetTuning) -> Float[np.ndarray, "components pairs"]:
    """Principal components of what is left of log distances, each of one standard deviation."""
    if len(rest) < 3:
        return np.zeros((0, rest.shape[1]))
    _, length, direction = np.linalg.svd(np.nan_to_num(rest) / np.sqrt(len(rest) - 1), full_matrices=False)
    most = min(tuning.max_components, len(rest) - 1)
    found = length[:most, None] * direction[:most]
    return found * np.sign(found[np.arange(most), np.abs(found).argmax(1)])[:, None]


def _mean(values: np.ndarray) -> np.ndarray:
    """Mean over subjects of what is known, NaN where nothing is."""
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(0)
    return np.where(known.any(0), total / np.maximum(known.sum(0), 1), np.nan)


def _median(values: np.ndarray) -> np.ndarray:
    """Median along the first axis of what is known, NaN where nothing is."""
    found = np.full(values.shape[1:], np.nan)
    some = np.isfinite(values).any(0)
    if some.any():
        found[some] = np.nanmedian(values[:, some] if values.ndim > 1 else values, axis=0)
    return found
