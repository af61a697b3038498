"""What all distances of a frame say together."""

from dataclasses import replace

import numpy as np
import pytest

from dshpm_jax import Settings
from dshpm_jax._control.full.distances import distance_llr
from dshpm_jax._control.problem import LabellingProblem


def test_a_distance_that_fits_nothing_says_nothing(problem):
    places = np.full((2, problem.model.num_markers, 3), np.nan)
    places[:, :6] = np.random.default_rng(5).uniform(0, 400, (6, 3))
    places[1, 2] = 1e5
    without = places[:1].copy()
    without[0, 2] = np.nan
    assert distance_llr(problem, places)[1] == pytest.approx(distance_llr(problem, without)[0], abs=1e-3)


def test_a_model_may_know_no_distance_at_all(problem):
    blind = replace(problem.model, pair_mean=np.full_like(problem.model.pair_mean, np.nan))
    places = np.random.default_rng(6).normal(0, 400, (3, blind.num_markers, 3))
    assert (distance_llr(LabellingProblem(problem.trajectories, blind, Settings()), places) == 0).all()


def test_frames_are_judged_one_by_one(problem, monkeypatch):
    places = np.random.default_rng(6).normal(0, 400, (20, problem.model.num_markers, 3))
    places[np.random.default_rng(7).random(places.shape[:2]) < 0.3] = np.nan
    together = distance_llr(problem, places)
    monkeypatch.setattr("dshpm_jax._control.full.distances.FRAMES_AT_ONCE", 7)
    np.testing.assert_array_equal(distance_llr(problem, places), together)
    assert distance_llr(problem, places[:0]).shape == (0,)


def test_the_sum_over_pairs_by_a_slow_loop(problem):
    """Of each pair the t-like log ratio, nothing below zero; each marker's pairs weigh `distance_weight` together."""
    rng = np.random.default_rng(8)
    places = np.where(rng.random((problem.model.num_markers, 1)) < 0.6, rng.normal(0, 400, (34, 3)), np.nan)
    model, tuning, total = problem.model, problem.tuning, 0.0
    for a in range(34):
        for b in range(a):
            mean, spread = model.pair_mean[a, b], model.pair_spread[a, b]
            sd = np.sqrt(spread**2 + (problem.settings.tolerance_ratio * mean) ** 2 + tuning.pair_noise_mm**2)
            error = (np.linalg.norm(places[a] - places[b]) - mean) / sd
            ratio = np.log(tuning.background_mm / sd) - (tuning.t_dof + 1) / 2 * np.log1p(error**2 / tuning.t_dof)
            total += max(ratio, 0.0) if np.isfinite(ratio) else 0.0
    wanted = total * tuning.distance_weight / 34
    assert distance_llr(problem, places[None])[0] == pytest.approx(wanted, rel=1e-4)
