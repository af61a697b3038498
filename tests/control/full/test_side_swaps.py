"""Chains that carry each other's labels: which are counterparts, and that their exchange is undone."""

import numpy as np
import pytest
from takes import model, take

from dshpm_jax import Settings
from dshpm_jax._control.full.evidence import evidence_in, sample_frames
from dshpm_jax._control.full.neighbourhoods.side_swaps import swap_sides
from dshpm_jax._control.full.objective import Incumbent, Solution
from dshpm_jax._control.full.refine import refine_labels
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._driver import Driver
from dshpm_jax._pretracking import pretrack


@pytest.fixture(scope="module")
def problem_and_truth():
    recording, truth = take(0)
    tracks = pretrack(recording)
    column = tracks.column[tracks.start, tracks.slot]
    return LabellingProblem(tracks, model(), Settings()), truth.numbered_by(model().markers)[tracks.start, column]


def changes(to: np.ndarray) -> dict[str, str]:
    """By name, what an exchange makes of the labels that it changes."""
    names = model().markers
    return {names[a]: names[b] for a, b in enumerate(to) if a != b}


def other_side(name: str) -> str:
    return {"L": "R", "R": "L"}[name[0]] + name[1:]


def test_limbs_are_counterparts_of_those_across(problem_and_truth):
    problem, _ = problem_and_truth
    of_one_kind = [
        names for names in map(changes, problem.prepared.side_permutations) if all(n[0] in "LR" for n in names)
    ]
    assert any({"LELB", "LWRA"} <= names.keys() for names in of_one_kind)
    assert any({"LKNE", "LANK"} <= names.keys() for names in of_one_kind)
    swaps = [names for names in of_one_kind if names == {name: other_side(name) for name in names}]
    assert any("LELB" in names for names in swaps) and any("LKNE" in names for names in swaps)


def test_an_exchange_gives_every_label_once(problem_and_truth):
    problem, _ = problem_and_truth
    for to in problem.prepared.side_permutations:
        assert sorted(to) == list(range(model().num_markers))


def test_every_exchange_is_undone(problem_and_truth):
    problem, truth = problem_and_truth
    driver = Driver()
    for to in problem.prepared.side_permutations:
        turned = np.where(truth >= 0, to[truth], truth)
        incumbent = Incumbent(next(driver.run([refine_labels(problem, turned)])))
        before = incumbent.objective
        next(driver.run([swap_sides(problem, incumbent)]))
        found = incumbent.solution
        assert found.objective >= before
        touched = (truth >= 0) & (turned != truth)
        assert (found.identity[touched] == truth[touched]).mean() > 0.95, changes(to)


def test_legs_exchanged_for_a_while_are_exchanged_back():
    recording, right = take(3, frames=600, gaps=0.4)
    tracks = pretrack(recording)
    problem = LabellingProblem(tracks, model(), Settings())
    truth = right.numbered_by(model().markers)[tracks.start, tracks.column[tracks.start, tracks.slot]]
    legs = next(
        to
        for to in problem.prepared.side_permutations
        if {"LKNE", "LANK"} <= changes(to).keys() <= set(model().markers)
    )
    inside = (truth >= 0) & (tracks.start >= 150) & (tracks.stop <= 450)
    exchanged = np.where(inside, legs[truth], truth)
    assert (exchanged != truth).sum() > 5
    driver = Driver()
    evidence = next(driver.run([evidence_in(problem, exchanged, sample_frames(problem))]))
    incumbent = Incumbent(Solution.of(problem, exchanged, evidence))
    next(driver.run([swap_sides(problem, incumbent)]))
    assert (incumbent.solution.identity[exchanged != truth] == truth[exchanged != truth]).mean() > 0.95
