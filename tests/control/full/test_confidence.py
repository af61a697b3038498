"""How sure a label is, and which are withheld."""

from dataclasses import replace

import numpy as np
import pytest

from dshpm_jax import Reason, Settings
from dshpm_jax._control.full.confidence import (
    _alternatives,
    _judged_swaps,
    _rivals,
    _Swap,
    ceiling_of,
    confidence_features,
    finalise,
)
from dshpm_jax._control.full.moves import Move
from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.full.own_distances import own_distances
from dshpm_jax._control.full.refine import refine_labels
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._types import NO_MATCH


def with_tuning(problem, **numbers) -> LabellingProblem:
    return LabellingProblem(problem.trajectories, problem.model, problem.settings, replace(TUNING, **numbers))


def test_no_label_of_a_doubtful_model_is_certain(problem, truth, run):
    share = TUNING.poor_fit_share
    assert ceiling_of(TUNING.poor_fit_below) == 1.0 and problem.settings.min_confidence < share
    solution = run(refine_labels(problem, truth))
    sure = run(finalise(problem, solution))
    unsure = run(finalise(with_tuning(problem, poor_fit_below=100.0), solution))
    np.testing.assert_array_equal(unsure.identity, sure.identity)
    named = sure.identity != NO_MATCH
    np.testing.assert_array_equal(unsure.confidence[named], np.minimum(sure.confidence[named], share))
    np.testing.assert_array_equal(unsure.confidence[~named], sure.confidence[~named])


def test_no_label_is_certain_where_votes_were_divided(problem, truth, run):
    solution = run(refine_labels(problem, truth))
    sure, unsure = (run(finalise(problem, replace(solution, divided=divided))) for divided in (False, True))
    named = sure.identity != NO_MATCH
    assert sure.confidence[named].max() > TUNING.divided_share > problem.settings.min_confidence
    np.testing.assert_array_equal(unsure.confidence[named], np.minimum(sure.confidence[named], TUNING.divided_share))


@pytest.mark.parametrize(("least", "none_left"), [(0.0, False), (1.0, True)])
def test_labels_under_the_least_confidence_are_withheld(problem, truth, run, least, none_left):
    strict = LabellingProblem(problem.trajectories, problem.model, Settings(min_confidence=least))
    solution = run(refine_labels(strict, truth))
    final = run(finalise(strict, solution))
    named = solution.identity != NO_MATCH
    assert (final.identity[named] == NO_MATCH).all() == none_left
    withheld = named & (final.identity == NO_MATCH)
    assert {final.reason[j] for j in np.flatnonzero(withheld)} <= {Reason.AMBIGUOUS, Reason.DOUBTFUL}
    assert withheld.any() == none_left
    assert (final.could_be[withheld, 0] == solution.identity[withheld]).all()


def test_what_else_a_trajectory_could_be(problem):
    llr = np.array([[9.0, 8.0, 1.0], [9.0, 1.0, 1.5], [3.0, 9.0, 4.0], [1.0, 5.0, 6.0]])
    solution = Solution(np.array([0, 0, 1, NO_MATCH]), llr, 0.0, None)  # type: ignore[arg-type]
    given_out = np.array([0, 0, NO_MATCH, NO_MATCH])
    none = NO_MATCH
    assert _alternatives(problem, solution, given_out).tolist() == [[1, none], [none, none], [1, 2], [2, none]]


def test_log_odds_add_up_by_the_weights_of_the_tuning(problem, truth, run):
    solution, t = run(refine_labels(problem, truth)), problem.trajectories
    open_to_all = LabellingProblem(t, problem.model, Settings(min_confidence=0.0))
    final, own = run(finalise(open_to_all, solution)), own_distances(problem, solution)
    swaps = run(_judged_swaps(open_to_all, solution))
    swap, rivals = run(confidence_features(open_to_all, solution))[:, 5], _rivals(open_to_all, swaps)
    for j in np.flatnonzero(solution.identity != NO_MATCH):
        seconds = np.clip((t.stop[j] - t.start[j]) / t.rate, *TUNING.confidence_seconds)
        llr = solution.llr[j, solution.identity[j]]
        odds = TUNING.confidence_base + TUNING.confidence_per_decade * np.log10(seconds)
        odds += TUNING.confidence_per_nat * np.clip(llr, *TUNING.confidence_llr)
        odds += TUNING.confidence_per_own_nat * np.clip(own.llr[j], *TUNING.confidence_own_llr)
        odds += TUNING.confidence_per_margin_nat * np.clip(own.margin[j], *TUNING.confidence_margin)
        odds += TUNING.confidence_per_swap_nat * swap[j]
        shared = 1 / (1 + rivals[j])
        assert final.confidence[j] == pytest.approx(min(1 / (1 + np.exp(-odds)), shared))


def test_equal_readings_share_the_probability(problem):
    """Two others that lose nothing leave a third; one that loses a nat a frame in ten frames leaves nearly all."""
    whole, moves = np.arange(2), []
    for loss, which in ((0.0, whole), (-0.1, whole[:1]), (1.0, whole[1:])):
        moves.append(_Swap(Move(which, which.astype(np.int32), 0.0), 100, loss))
    rivals = _rivals(problem, moves)
    assert rivals[0] == 2.0 and rivals[1] == pytest.approx(1.0 + np.exp(-10.0)) and not rivals[2:].any()


def test_a_label_is_less_sure_where_a_swap_costs_little(problem, truth, run):
    solution = run(refine_labels(problem, truth))
    features = run(confidence_features(problem, solution))
    named = solution.identity != NO_MATCH
    assert features.shape == (len(truth), 6) and (features[:, 0] == 1.0).all()
    assert (features[named, 5] >= 0.0).all() and features[named, 5].max() == TUNING.confidence_swap_loss[1]
