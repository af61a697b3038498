"""The search as a whole: key-frames, restarts, stages, several starts."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from takes import model, shares, take

from dshpm_jax import Reason, label_many
from dshpm_jax._control.full.confidence import finalise
from dshpm_jax._control.full.objective import Incumbent, better_of
from dshpm_jax._control.full.refine import refine_labels
from dshpm_jax._control.full.search import search, solve
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._requests import CountFits
from dshpm_jax._types import NO_MATCH


def searched(problem):
    """The solution, and the rigid fits that it took."""
    solution = yield from search(problem)
    return solution, (yield CountFits())


def test_what_is_given_out_is_right_and_the_rest_has_a_reason(problem, truth, run):
    solution, fits = run(searched(problem))
    final = run(finalise(problem, solution))
    given = final.identity != NO_MATCH
    assert fits > 0 and (final.identity[given] == truth[given]).all()
    assert ((0 <= final.confidence) & (final.confidence <= 1)).all()
    assert all((r is Reason.MATCHED) == g for r, g in zip(final.reason, given))


def test_divided_votes_lead_to_more_starts(problem, truth, run):
    solution, fits = run(searched(problem))
    always = LabellingProblem(problem.trajectories, problem.model, problem.settings, replace(TUNING, divided_below=1.1))
    best, more_fits = run(searched(always))
    assert best.divided and not solution.divided
    assert more_fits > 3 * fits and best.objective >= solution.objective
    kept, before = best.identity != NO_MATCH, solution.identity != NO_MATCH
    assert (best.identity[kept] == truth[kept]).mean() > 0.99 and kept.mean() > 0.95 * before.mean()


def test_a_label_that_other_starts_do_not_lead_to_is_taken_back(problem, truth, run, monkeypatch):
    solutions = [run(refine_labels(problem, truth))] * 4
    odd = np.flatnonzero(solutions[0].identity != NO_MATCH)[0]
    for k in (1, 2):
        other = solutions[k].identity.copy()
        other[odd] = NO_MATCH
        solutions[k] = replace(solutions[k], identity=other)
    queue = iter(solutions)

    def led_by(problem, votes, scale):
        votes.count[0, :2] = 1  # divided: two votes, and no label
        yield from ()
        return next(queue)

    monkeypatch.setattr("dshpm_jax._control.full.search._led_by", led_by)
    found = run(search(problem))
    assert found.identity[odd] == NO_MATCH
    np.testing.assert_array_equal(np.delete(found.identity, odd), np.delete(solutions[0].identity, odd))


def test_half_of_the_points_are_enough():
    recording, right = take(1, frames=300, gaps=0.5, ghosts=0.0)
    (labelling,) = label_many([recording], [model()])
    labelled, wrong = shares(labelling.identities, recording, right)
    assert labelled > 0.95 and wrong < 0.02


def test_another_solution_is_taken_if_it_is_worth_more(problem, truth, run):
    found = run(search(problem))
    richer = replace(run(refine_labels(problem, truth)), objective=2 * found.objective)
    for other in (richer, replace(richer, objective=-np.inf)):
        _, taken = run(solve(problem, other))
        assert taken is better_of(other, found) or (taken.identity == found.identity).all()


def test_what_rematching_found_may_swap_the_rest(problem, run, monkeypatch):
    """A leg that is found again can show that the other one carries its labels."""

    def stage(step):
        def control(problem, incumbent):
            yield from ()
            now = incumbent.objective
            incumbent.solution = SimpleNamespace(objective=step.get(now, now))

        return control

    def started(*_):
        yield from ()
        return SimpleNamespace(objective=1)

    improve, swap, again = stage({}), stage({2: 3}), stage({1: 2})
    parts = {
        "improve": improve,
        "swap_sides": swap,
        "STAGES": (improve, swap, again, improve),
        "_started": started,
        "share_held": lambda *_: 1.0,
        "Incumbent": Incumbent,
    }
    for name, part in parts.items():
        monkeypatch.setattr(f"dshpm_jax._control.full.search.{name}", part)
    assert run(search(problem)).objective == 3
