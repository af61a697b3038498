"""What is finally given out: labels, how sure each is, and why a trajectory has none."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._control.full.assignment import margins
from dshpm_jax._control.full.moves import Move, around_fixed, frames_touched, judge_moves
from dshpm_jax._control.full.neighbourhoods.exchanges import propose_turns
from dshpm_jax._control.full.neighbourhoods.near_swaps import propose_near_swaps
from dshpm_jax._control.full.objective import Solution, model_fit
from dshpm_jax._control.full.own_distances import own_distances
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._labelling import Reason
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH

WEIGHTS = (
    "confidence_base",
    "confidence_per_nat",
    "confidence_per_decade",
    "confidence_per_own_nat",
    "confidence_per_margin_nat",
    "confidence_per_swap_nat",
)
"""The fields of `Tuning` that the log odds of a label are summed with, in the order of `confidence_features`."""


@dataclass(frozen=True, eq=False)
class FinalLabels:
    """The labels of a recording's trajectories as they are given out.

    Attributes:
        identity: the marker of each, `NO_MATCH` where unlabelled or withheld.
        confidence: the probability that the label is right, or that none is.
        reason: why each has its label or none.
        could_be: the label withheld from each, then the best of the others that would pay; `NO_MATCH` beyond.
        model_fit: see `objective.model_fit`.
        against: which labels are given although the evidence is against them.
    """

    identity: Int[np.ndarray, " trajectories"]
    confidence: Float[np.ndarray, " trajectories"]
    reason: tuple[Reason, ...]
    could_be: Int[np.ndarray, "trajectories 2"]
    model_fit: float
    against: Bool[np.ndarray, " trajectories"]


def finalise(problem: LabellingProblem, solution: Solution, fit: float | None = None) -> Control[FinalLabels]:
    """The labels as they are given out: those less likely to be right than `Settings.min_confidence` are withheld.

    Arguments:
        fit: the model fit of the whole recording, where the problem is a part of it.
    """
    t, tuning = problem.trajectories, problem.tuning
    fit = model_fit(problem, solution) if fit is None else fit
    fit = round(fit, 4)  # as it is told, so that line and confidences agree
    named = solution.identity != NO_MATCH
    swaps = yield from _judged_swaps(problem, solution)
    chance = np.minimum(_chance(problem, solution, swaps), ceiling_of(fit, tuning))
    chance = np.minimum(chance, 1.0 / (1.0 + _rivals(problem, swaps)))
    chance = np.minimum(chance, tuning.divided_share if solution.divided else 1.0)
    best = solution.llr.max(1)
    none = _logistic(tuning.accept_llr - best)
    fixed = problem.fixed
    withheld = named & (chance < problem.settings.min_confidence) & ~fixed.given
    margin = margins(solution.identity, solution.llr, t.start, t.stop)
    reason = np.where(best > tuning.accept_llr, Reason.TAKEN, Reason.OUTSIDE)
    reason = np.where(named, Reason.MATCHED, reason)
    reason = np.where(withheld, np.where(margin < tuning.near_tie_llr, Reason.AMBIGUOUS, Reason.DOUBTFUL), reason)
    identity = np.where(withheld, NO_MATCH, solution.identity)
    confidence = np.where(withheld, 1.0 - chance, np.where(named, chance, none))
    reason, confidence = np.where(fixed.given, Reason.KNOWN, reason), np.where(fixed.given, 1.0, confidence)
    could_be = _alternatives(problem, solution, identity)
    own = solution.llr[np.arange(len(t)), np.maximum(identity, 0)]
    against = fixed.given & (identity != NO_MATCH) & (own < tuning.known_doubt_llr)
    return FinalLabels(identity, confidence, tuple(map(Reason, reason)), could_be, fit, against)


def ceiling_of(fit: float, tuning: Tuning = TUNING) -> float:
    """How sure labels can be at most where the model fits so well, see `objective.model_fit`."""
    return tuning.poor_fit_share if fit < tuning.poor_fit_below else 1.0


def _alternatives(
    problem: LabellingProblem, solution: Solution, identity: Int[np.ndarray, " trajectories"]
) -> Int[np.ndarray, "trajectories 2"]:
    """The label withheld from each trajectory, then the best of the others that would pay; `NO_MATCH` beyond.

    Arguments:
        identity: the labels given out.
    """
    llr = solution.llr.copy()
    named = np.flatnonzero(solution.identity != NO_MATCH)
    llr[named, solution.identity[named]] = -np.inf
    other = np.where(llr.max(1) > problem.tuning.accept_llr, llr.argmax(1), NO_MATCH)
    kept = identity == solution.identity
    first, second = np.where(kept, other, solution.identity), np.where(kept, NO_MATCH, other)
    return np.stack([first, second], axis=1).astype(np.int32)


class _Swap(NamedTuple):
    """Another reading: a move, in how many frames it changes labels, and what it loses in each (nats)."""

    move: Move
    frames: int
    loss: float


def _judged_swaps(problem: LabellingProblem, solution: Solution) -> Control[list[_Swap]]:
    """Near labels exchanged, and segments turned onto themselves, with what each would lose."""
    proposed = [*propose_near_swaps(problem, solution.identity), *propose_turns(problem, solution.identity)]
    moves = [move for move in (around_fixed(problem, move) for move in proposed) if len(move.trajectories)]
    if not moves:
        return []
    worth = yield from judge_moves(problem, solution, moves)
    frames = [frames_touched(problem, move) for move in moves]
    return [_Swap(move, n, -float(gain) / n) for move, n, gain in zip(moves, frames, worth, strict=True)]


def _rivals(problem: LabellingProblem, swaps: Sequence[_Swap]) -> Float[np.ndarray, " trajectories"]:
    """How probable other readings are of each trajectory, as multiples of the one at hand.

    Readings that fit equally well share the probability: those of a square plate, or of two markers in one place.
    """
    odds = np.zeros(len(problem.trajectories))
    for swap in swaps:
        frames = min(swap.frames, problem.tuning.rival_frames)
        odds[swap.move.trajectories] += np.exp(-frames * max(swap.loss, 0.0))
    return odds


def _chance(
    problem: LabellingProblem, solution: Solution, swaps: Sequence[_Swap]
) -> Float[np.ndarray, " trajectories"]:
    """The probability that each label is right by its own evidence; means nothing where there is none."""
    tuning = problem.tuning
    share = tuning.rescaled_share if problem.settings.rescale else 1.0
    weights = np.array([getattr(tuning, name) for name in WEIGHTS])
    return share * _logistic(_features(problem, solution, swaps) @ weights)


def confidence_features(
    problem: LabellingProblem, solution: Solution
) -> Control[Float[np.ndarray, "trajectories features"]]:
    """What the log odds of each label are a weighted sum of, each bounded on both sides so that none decides alone.

    They are 1, its mean evidence (nats), the decades of its life in seconds, what the recording's own distances say of
    it (nats), by how much more than of its best rival (nats), and what it would cost to exchange it with a near label
    (nats a frame).
    """
    return _features(problem, solution, (yield from _judged_swaps(problem, solution)))


def _features(
    problem: LabellingProblem, solution: Solution, swaps: Sequence[_Swap]
) -> Float[np.ndarray, "trajectories features"]:
    t, tuning = problem.trajectories, problem.tuning
    own = own_distances(problem, solution)
    cheapest = np.full(len(t), np.inf)
    for swap in swaps:
        cheapest[swap.move.trajectories] = np.minimum(cheapest[swap.move.trajectories], swap.loss)
    values_and_bounds = (
        (solution.llr[np.arange(len(t)), np.maximum(solution.identity, 0)], tuning.confidence_llr),
        (np.log10(np.clip((t.stop - t.start) / t.rate, *tuning.confidence_seconds)), (-np.inf, np.inf)),
        (own.llr, tuning.confidence_own_llr),
        (own.margin, tuning.confidence_margin),
        (cheapest, tuning.confidence_swap_loss),
    )
    bounded = [np.clip(values, low, high) for values, (low, high) in values_and_bounds]
    return np.stack([np.ones(len(t)), *bounded], axis=1)


def _logistic(log_odds: np.ndarray) -> np.ndarray:
    return 1.0 / (1.0 + np.exp(-np.clip(log_odds, -30.0, 30.0)))
