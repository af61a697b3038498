"""How sure a label is, and which are withheld."""

from dataclasses import replace

import numpy as np
import pytest

from dshpm_jax import Reason, Settings
from dshpm_jax._control.full.confidence import _alternatives, ceiling_of, finalise
from dshpm_jax._control.full.objective import Solution
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
    sure, unsure = finalise(problem, solution), finalise(with_tuning(problem, poor_fit_below=100.0), solution)
    np.testing.assert_array_equal(unsure.identity, sure.identity)
    named = sure.identity != NO_MATCH
    np.testing.assert_array_equal(unsure.confidence[named], np.minimum(sure.confidence[named], share))
    np.testing.assert_array_equal(unsure.confidence[~named], sure.confidence[~named])


@pytest.mark.parametrize(("least", "none_left"), [(0.0, False), (1.0, True)])
def test_labels_under_the_least_confidence_are_withheld(problem, truth, run, least, none_left):
    strict = LabellingProblem(problem.trajectories, problem.model, Settings(min_confidence=least))
    solution = run(refine_labels(strict, truth))
    final = finalise(strict, solution)
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


def test_a_second_of_life_and_each_nat_and_decade_are_worth_what_the_tuning_says(problem, truth, run):
    """Log odds add up, clipped where the tuning says."""
    solution, t = run(refine_labels(problem, truth)), problem.trajectories
    open_to_all = LabellingProblem(t, problem.model, Settings(min_confidence=0.0))
    final = finalise(open_to_all, solution)
    for j in np.flatnonzero(solution.identity != NO_MATCH):
        own = np.clip(solution.llr[j, solution.identity[j]], *TUNING.confidence_llr)
        seconds = np.clip((t.stop[j] - t.start[j]) / t.rate, *TUNING.confidence_seconds)
        odds = TUNING.confidence_base + TUNING.confidence_per_nat * own
        odds += TUNING.confidence_per_decade * np.log10(seconds)
        assert final.confidence[j] == pytest.approx(1 / (1 + np.exp(-odds)))
