"""Probabilities from evidence, fitted to what proved right; numpy alone."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

WIDTHS = 4.0, 2.0, 2.0, 2.0, 2.0, 2.0
"""Standard deviations of a fitted coefficient about where it started: where all is right nothing else bounds it."""

STEPS = 100  # of Newton's method at most
THRESHOLDS = np.arange(0.5, 1.0, 0.05).round(2)  # under which a model may be said to fit badly
LEAST_POOR = 3  # recordings that it takes to fit a threshold and a share
BINS = (0.7, 0.95), (0.95, 0.99), (0.99, np.inf)  # of probabilities, half-open
SURE = 1e-6  # no probability counts as farther from 0 and 1 than this


class Numbers(NamedTuple):
    """The fitted numbers, by the names of their fields in `Tuning` where they have one.

    Attributes:
        weights: of the features that the log odds of a label are a sum of, see `confidence_features`.
        poor_fit_below, poor_fit_share: labels of a recording whose `model_fit` is less are no surer than the share.
        rescaled_share: of the labels that are right with another subject's model, rescaled.
        finding_per_llr: log odds that a finding of `check` is right, for a nat.
    """

    weights: tuple[float, ...]
    poor_fit_below: float
    poor_fit_share: float
    rescaled_share: float
    finding_per_llr: float


@dataclass(frozen=True, eq=False)
class Labels:
    """Labelled trajectories.

    Attributes:
        data_set: the data set of each.
        recording: a number that those of one recording share.
        features: what its log odds are a weighted sum of, see `confidence_features`.
        right: whether the label is.
        model_fit: that of the recording.
        rescaled: whether the model was another subject's.
    """

    data_set: np.ndarray
    recording: Int[np.ndarray, " trajectories"]
    features: Float[np.ndarray, "trajectories features"]
    right: Bool[np.ndarray, " trajectories"]
    model_fit: Float[np.ndarray, " trajectories"]
    rescaled: Bool[np.ndarray, " trajectories"]

    def __len__(self) -> int:
        return len(self.right)

    def where(self, which: np.ndarray) -> "Labels":
        return replace(self, **{name: column[which] for name, column in vars(self).items()})


@dataclass(frozen=True, eq=False)
class Findings:
    """What `check` said: the data set, how decisive it was (nats), and whether it is right."""

    data_set: np.ndarray
    llr: Float[np.ndarray, " findings"]
    right: Bool[np.ndarray, " findings"]

    def __len__(self) -> int:
        return len(self.right)

    def where(self, which: np.ndarray) -> "Findings":
        return replace(self, **{name: column[which] for name, column in vars(self).items()})


def fit_logistic(
    features: Float[np.ndarray, "rows k"], right: Bool[np.ndarray, " rows"], start: Sequence[float]
) -> Float[np.ndarray, " k"]:
    """The coefficients of log odds under which what is right is most probable, not far from `start` (see `WIDTHS`)."""
    centre = np.array(start, float)
    weight = np.array(WIDTHS[: len(centre)]) ** -2.0
    found, least = centre, _cost(centre, features, right, centre, weight)
    for _ in range(STEPS):
        p = logistic(features @ found)
        slope = features.T @ (p - right) + weight * (found - centre)
        curvature = (features * (p * (1 - p))[:, None]).T @ features + np.diag(weight)
        step = np.linalg.solve(curvature, slope)
        for shorter in 0.5 ** np.arange(30):
            cost = _cost(found - shorter * step, features, right, centre, weight)
            if cost < least:
                found, least = found - shorter * step, cost
                break
        else:
            return found
    return found


def _cost(found, features, right, centre, weight) -> float:
    odds = features @ found
    return float(np.logaddexp(0.0, np.where(right, -odds, odds)).sum() + 0.5 * (weight * (found - centre) ** 2).sum())


def chance(numbers: Numbers, labels: Labels) -> Float[np.ndarray, " trajectories"]:
    """The probability that each label is right, as these numbers have it."""
    sure = logistic(labels.features @ np.array(numbers.weights))
    sure = np.where(labels.rescaled, numbers.rescaled_share, 1.0) * sure
    return np.where(labels.model_fit < numbers.poor_fit_below, np.minimum(sure, numbers.poor_fit_share), sure)


def finding_chance(numbers: Numbers, findings: Findings) -> Float[np.ndarray, " findings"]:
    return logistic(numbers.finding_per_llr * findings.llr)


def fitted(labels: Labels, findings: Findings, now: Numbers) -> Numbers:
    """The numbers that fit best; those of which the data say nothing stay as they are."""
    own = labels.where(~labels.rescaled)
    sound = own.where(own.model_fit >= now.poor_fit_below)
    weights = tuple(fit_logistic(sound.features, sound.right, now.weights).tolist()) if len(sound) else now.weights
    numbers = _with_poor_fits(now._replace(weights=weights), own)
    if labels.rescaled.any():
        numbers = numbers._replace(rescaled_share=float(labels.right[labels.rescaled].mean()))
    if len(findings):
        (per_llr,) = fit_logistic(findings.llr[:, None], findings.right, [now.finding_per_llr])
        numbers = numbers._replace(finding_per_llr=float(per_llr))
    return numbers


def _with_poor_fits(numbers: Numbers, labels: Labels) -> Numbers:
    """The threshold and the share under it by which all labels are most probable, the first of equals."""
    best, least = numbers, np.inf
    for threshold in THRESHOLDS.tolist():
        poor = labels.model_fit < threshold
        if len(np.unique(labels.recording[poor])) < LEAST_POOR:
            continue
        here = numbers._replace(poor_fit_below=threshold, poor_fit_share=float(labels.right[poor].mean()))
        loss = log_loss(chance(here, labels), labels.right)
        if loss < least:
            best, least = here, loss
    return best


def left_out(labels: Labels, findings: Findings, now: Numbers) -> Iterator[tuple[str, Numbers]]:
    """For each data set the numbers that all others lead to."""
    for name in sorted({*labels.data_set.tolist(), *findings.data_set.tolist()}):
        yield name, fitted(labels.where(labels.data_set != name), findings.where(findings.data_set != name), now)


def reliability(p: Float[np.ndarray, " rows"], right: Bool[np.ndarray, " rows"]) -> list[tuple[int, float]]:
    """How many probabilities are in each of `BINS`, and the share that is right of them; NaN where there are none."""
    inside = [(low <= p) & (p < high) for low, high in BINS]
    return [(int(here.sum()), float(right[here].mean()) if here.any() else np.nan) for here in inside]


def log_loss(p: Float[np.ndarray, " rows"], right: Bool[np.ndarray, " rows"]) -> float:
    """Mean surprise at what proved right (nats); NaN without any row."""
    p = np.clip(p, SURE, 1 - SURE)
    return float(-np.log(np.where(right, p, 1 - p)).mean()) if len(p) else float("nan")


def logistic(log_odds: np.ndarray) -> np.ndarray:
    return 1.0 / (1.0 + np.exp(-np.clip(log_odds, -30.0, 30.0)))
