"""Near labels that are exchanged, for good or for a while: proposed, and put right."""

import numpy as np
import pytest
from takes import model

from dshpm_jax._control.full.evidence import evidence_in, sample_frames
from dshpm_jax._control.full.neighbourhoods.near_swaps import propose_near_swaps, swap_near
from dshpm_jax._control.full.objective import Incumbent, Solution
from dshpm_jax._types import NO_MATCH


def judged(problem, labels):
    return Solution.of(problem, labels, (yield from evidence_in(problem, labels, sample_frames(problem))))


def number(name: str) -> int:
    return model().markers.index(name)


@pytest.mark.parametrize("pair", [("LWRA", "LWRB"), ("RTOE", "RHEE"), ("LFHD", "LBHD")])
def test_two_near_labels_are_proposed_back_and_put_right(problem, truth, run, pair):
    a, b = map(number, pair)
    wrong = np.where(truth == a, b, np.where(truth == b, a, truth))
    moves = propose_near_swaps(problem, wrong)
    moved = {(int(j), int(label)) for move in moves for j, label in zip(move.trajectories, move.labels, strict=True)}
    assert moved >= {(int(j), int(truth[j])) for j in np.flatnonzero(wrong != truth)}
    incumbent = Incumbent(run(judged(problem, wrong)))
    run(swap_near(problem, incumbent))
    named = truth != NO_MATCH
    assert (incumbent.solution.identity[named] == truth[named]).all()


def test_one_in_the_place_of_another_that_is_not_worn(problem, truth, run):
    """The other's own trajectories are left out, so that its label is free."""
    a, b = number("LWRA"), number("LWRB")
    wrong = np.where(truth == b, NO_MATCH, np.where(truth == a, b, truth))
    incumbent = Incumbent(run(judged(problem, wrong)))
    run(swap_near(problem, incumbent))
    assert (incumbent.solution.identity[truth == a] == a).all()


def test_right_labels_stay(problem, truth, run):
    incumbent = Incumbent(run(judged(problem, truth)))
    run(swap_near(problem, incumbent))
    named = truth != NO_MATCH
    assert (incumbent.solution.identity[named] == truth[named]).all()


def test_the_best_come_first_and_no_more_than_allowed(problem, truth):
    promises = [move.promise for move in propose_near_swaps(problem, truth)]
    assert promises == sorted(promises, reverse=True) and len(promises) <= problem.tuning.max_near_swaps
    assert all(promise > -problem.tuning.max_near_loss for promise in promises)


def test_nothing_labelled(problem, truth):
    assert propose_near_swaps(problem, np.full_like(truth, NO_MATCH)) == []
