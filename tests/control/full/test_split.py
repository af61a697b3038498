"""Trajectories that change from one marker to another are cut there, and no others."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from takes import model

from dshpm_jax import Settings
from dshpm_jax._control.full.search import solve
from dshpm_jax._control.full.split import propose_cuts
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._driver import Driver
from dshpm_jax._trajectories import from_columns
from dshpm_jax.synthesis import person

FRAMES, RATE = 120, 60.0


def walk() -> tuple[np.ndarray, np.ndarray]:
    """Points of a walk, and the marker of each column."""
    recording = person(34, frames=FRAMES, rate=RATE, seed=5).recording
    return recording.points, np.array([model().markers.index(label) for label in recording.labels])


def exchanged(a: str, b: str, first: int, last: int) -> tuple[LabellingProblem, np.ndarray]:
    """Trajectories of which two are each other's in some frames, without a leap that would show; markers by column."""
    points, truth = walk()
    i, k = (truth.tolist().index(model().markers.index(name)) for name in (a, b))
    links = np.tile(np.arange(points.shape[1]), (FRAMES, 1))
    for frame in (first, last):
        if 0 < frame < FRAMES:
            links[frame - 1, [i, k]] = k, i
    return LabellingProblem(from_columns(points, RATE, links), model(), Settings()), truth


def solved(problem: LabellingProblem):
    return next(Driver().run([solve(problem)]))


@pytest.mark.parametrize(
    ("pair", "first", "last"),
    [(("LWRA", "LTHI"), 40, FRAMES), (("LANK", "RANK"), 70, FRAMES), (("RELB", "RKNE"), 45, 85)],
)
def test_exchanged_points_are_told_apart(pair, first, last):
    problem, truth = exchanged(*pair, first, last)
    assert len(problem.trajectories) == len(truth)
    problem, solution = solved(problem)
    found = problem.trajectories.by_column(solution.identity, len(truth))
    assert (found == truth).mean() > 0.99


def test_sound_trajectories_stay_whole():
    points, truth = walk()
    problem = LabellingProblem(from_columns(points, RATE), model(), Settings())
    same, solution = solved(problem)
    assert same is problem and not propose_cuts(problem, solution)
    assert (problem.trajectories.by_column(solution.identity, len(truth)) == truth).all()


@given(st.lists(st.tuples(st.integers(0, 33), st.integers(1, FRAMES - 1)), max_size=6, unique=True))
def test_cut_trajectories_hold_the_same_points(cuts):
    points, _ = walk()
    whole = from_columns(points, RATE)
    which, frame = (np.array([cut[k] for cut in cuts], int) for k in (0, 1))
    parts, source = whole.cut(which, frame)
    assert len(parts) == len(whole) + len(cuts)
    assert (np.diff(parts.start) >= 0).all() and (parts.start < parts.stop).all()
    assert (parts.by_column(source, points.shape[1]) == whole.by_column(np.arange(len(whole)), points.shape[1])).all()
    for j, at in cuts:
        assert at in parts.start[source == j] and at in parts.stop[source == j]
