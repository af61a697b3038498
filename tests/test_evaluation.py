"""Rates against counts made by hand, and against a slow count over random labellings."""

import numpy as np
import pytest
from hypothesis import given as over
from hypothesis import strategies as st

from dshpm_jax._types import NO_MATCH
from dshpm_jax.evaluation import (
    point_identification_rate,
    precision_recall_f1,
    scores_by_label,
    trajectory_identification_rate,
)

N = NO_MATCH
# marker 0 has a gap in frame 2, marker 1 changes its column there, the last column is a ghost in frames 1 and 2
TRUTH = np.array([[0, 1, N, N], [0, 1, N, N], [N, N, 1, N], [0, N, 1, N]])
GIVEN = np.array([[0, 1, N, N], [0, 0, N, 1], [N, N, 1, N], [N, N, 1, N]])


def test_counts_by_hand():
    scores = precision_recall_f1(GIVEN, TRUTH)
    assert scores == (5, 7, 7)
    assert (scores.precision, scores.recall, scores.f1) == pytest.approx((5 / 7, 5 / 7, 5 / 7))
    assert point_identification_rate(GIVEN, TRUTH) == pytest.approx(5 / 7)


def test_trajectories_by_hand():
    """Marker 0 has two trajectories, the first all right; marker 1 has one over two columns, right in 3 of 4 frames."""
    assert trajectory_identification_rate(GIVEN, TRUTH) == pytest.approx(1 / 3)
    assert trajectory_identification_rate(GIVEN, TRUTH, share=0.75) == pytest.approx(2 / 3)


def test_points_and_trajectories_are_two_quantities():
    truth = np.array([[0, 1]] * 95 + [[0, N]] * 5)
    given = truth.copy()
    given[:10, 1] = N
    assert point_identification_rate(given, truth) == pytest.approx(185 / 195)
    assert trajectory_identification_rate(given, truth) == 0.5


def test_scores_of_each_label():
    scores = scores_by_label(GIVEN, TRUTH, ("a", "b"))
    assert list(scores) == ["a", "b"]
    assert scores["a"] == (2, 3, 3)
    assert scores["b"] == (3, 4, 4)


def test_nothing_given_and_nothing_there():
    empty = np.full((3, 2), N)
    assert np.isnan(precision_recall_f1(empty, TRUTH[:3, :2]).precision)
    assert precision_recall_f1(empty, TRUTH[:3, :2]).f1 == 0
    assert np.isnan(point_identification_rate(empty, empty))
    assert np.isnan(trajectory_identification_rate(empty, empty))
    assert np.isnan(trajectory_identification_rate(empty[:0], empty[:0]))


def test_arrays_of_two_recordings():
    with pytest.raises(ValueError, match="same recording"):
        precision_recall_f1(GIVEN, TRUTH[:2])


@over(st.integers(0, 10_000))
def test_trajectories_against_a_slow_count(seed):
    rng = np.random.default_rng(seed)
    truth = np.stack([np.where(rng.random(5) < 0.7, rng.permutation(5), N) for _ in range(12)])
    given = np.where(rng.random(truth.shape) < 0.8, truth, rng.integers(-1, 5, truth.shape))
    runs = []
    for marker in range(5):
        before = False
        for t in range(12):
            at = np.flatnonzero(truth[t] == marker)
            if len(at):
                runs += [] if before else [[]]
                runs[-1].append(given[t, at[0]] == marker)
            before = len(at) > 0
    slow = np.mean([np.mean(run) >= 0.95 for run in runs])
    assert trajectory_identification_rate(given, truth) == pytest.approx(slow)
