"""A take of a synthetic person as a labelling problem, and its truth."""

import numpy as np
import pytest
from takes import model, take

from dshpm_jax import Settings
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._driver import Driver
from dshpm_jax._pretracking import pretrack

DRIVER = Driver()


@pytest.fixture(scope="session")
def problem_and_truth():
    recording, truth = take(0)
    tracks = pretrack(recording)
    right = truth.numbered_by(model().markers)
    column = tracks.column[tracks.start, tracks.slot]
    return LabellingProblem(tracks, model(), Settings()), right[tracks.start, column]


@pytest.fixture
def problem(problem_and_truth) -> LabellingProblem:
    return problem_and_truth[0]


@pytest.fixture
def truth(problem_and_truth) -> np.ndarray:
    return problem_and_truth[1]


@pytest.fixture
def run():
    """Runs a control to its end."""
    return lambda control: next(DRIVER.run([control]))
