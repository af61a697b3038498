"""Means over trials, with what they are worth."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from dshpm_jax._experiments.trials import TrialResult

NORMAL = 1.96  # standard errors of a 95 % interval


class Mean(NamedTuple):
    """A mean with its 95 % confidence interval."""

    mean: float
    low: float
    high: float


def mean_of(values: Sequence[float], within: tuple[float, float] = (-np.inf, np.inf)) -> Mean:
    """The mean over trials and its interval, by the normal distribution of means of independent trials.

    The points of a trial share its fate, so the trials are what is independent, not the points. Trials that all give
    the same leave no width.

    Arguments:
        within: where the quantity can lie at all.
    """
    mean = float(np.mean(values))
    error = NORMAL * float(np.std(values, ddof=1)) / np.sqrt(len(values)) if len(values) > 1 else np.nan
    low, high = np.clip((mean - error, mean + error), *within)
    return Mean(mean, float(low), float(high))


def rate_of(outcomes: Sequence[TrialResult]) -> Mean:
    """The rate of points over trials."""
    return mean_of([one.rate for one in outcomes], (0.0, 1.0))


def precision_of(outcomes: Sequence[TrialResult]) -> float:
    """The mean precision of the trials in which anything was labelled; NaN if none was."""
    values = [one.precision for one in outcomes if not np.isnan(one.precision)]
    return float(np.mean(values)) if values else float("nan")


def times_of(outcomes: Sequence[TrialResult]) -> tuple[float, float]:
    """Seconds that a trial took side by side with the others, on average, and that one alone took."""
    return float(np.mean([one.seconds for one in outcomes])), outcomes[0].alone
