"""The contract that every score keeps, those of the paper and those of researchers alike."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import dshpm_jax._scoring as scoring
from dshpm_jax._driver import Driver

CANDIDATE_SCORES = [s() for s in vars(scoring).values() if s in scoring.AbstractCandidateScore.__subclasses__()]
MATCH_SCORES = [s() for s in vars(scoring).values() if s in scoring.AbstractMatchScore.__subclasses__()]


def name(score) -> str:
    return type(score).__name__


candidate_scores = pytest.mark.parametrize("score", CANDIDATE_SCORES, ids=name)
match_scores = pytest.mark.parametrize("score", MATCH_SCORES, ids=name)


def candidate_cost(score, model, data, tolerance):
    return np.asarray(jax.jit(jax.vmap(score))(*(jnp.asarray(x, jnp.float32) for x in (model, data, tolerance))))


def match_cost(score, residuals, scale, matched):
    arrays = jnp.asarray(residuals, jnp.float32), jnp.asarray(scale, jnp.float32), jnp.asarray(matched, bool)
    return np.asarray(eqx.filter_jit(score)(*arrays))


def random_match(seed: int, markers: int = 9):
    rng = np.random.default_rng(seed)
    matched = np.arange(markers) < 6
    return np.where(matched, rng.uniform(0, 20, markers), 0.0), rng.uniform(4, 10, markers), matched


def test_there_are_scores_to_test():
    assert {"ToleranceScore"} <= set(map(name, CANDIDATE_SCORES))
    assert {"MeanResidual", "RmsResidual", "MaxResidual"} <= set(map(name, MATCH_SCORES))


@candidate_scores
def test_a_candidate_cost_is_one_finite_number(score):
    rng = np.random.default_rng(0)
    cost = candidate_cost(score, *rng.uniform(0.1, 2000, (3, 500)))
    assert cost.shape == (500,) and cost.dtype == np.float32 and np.isfinite(cost).all()


@candidate_scores
def test_padding_costs_no_nan(score):
    cost = candidate_cost(score, [0.0, 0.0, 300.0], [0.0, 1.7e6, 1.7e6], [1.0, 1.0, 4.0])
    assert not np.isnan(cost).any() and (cost[1:] > 1).all()


@candidate_scores
def test_the_right_distance_is_the_best_candidate(score):
    apart = np.array([0.0, 1.0, 3.0, 9.0, 27.0, 500.0])
    for sign in (1, -1):
        cost = candidate_cost(score, np.full(6, 600.0), 600 + sign * apart, np.full(6, 8.0))
        assert cost[0] <= 1 and (np.diff(cost) >= 0).all() and cost[-1] > 1


@candidate_scores
def test_more_tolerance_never_costs_more(score):
    cost = candidate_cost(score, np.full(4, 300.0), np.full(4, 310.0), [2.0, 5.0, 15.0, 100.0])
    assert (np.diff(cost) <= 0).all()


def test_eq_3_is_met_with_equality():
    score = scoring.ToleranceScore()
    assert candidate_cost(score, [100.0, 100.0], [110.0, 90.0], [10.0, 10.0]).tolist() == [1.0, 1.0]


@match_scores
@pytest.mark.parametrize("seed", range(3))
def test_a_match_cost_is_one_finite_number(score, seed):
    cost = match_cost(score, *random_match(seed))
    assert cost.shape == () and cost.dtype == np.float32 and np.isfinite(cost) and cost > 0


@match_scores
def test_a_perfect_match_is_the_best(score):
    _, scale, matched = random_match(0)
    perfect = match_cost(score, np.zeros(9), scale, matched)
    assert perfect < 1 and all(perfect <= match_cost(score, *random_match(seed)) for seed in range(3))


@match_scores
def test_residuals_at_the_limit_are_not_good_enough(score):
    _, scale, matched = random_match(0)
    limit = np.where(matched, scale, 0.0)
    assert match_cost(score, 1.01 * limit, scale, matched) >= 1
    assert match_cost(score, 0.99 * limit, scale, matched) < 1


@match_scores
@pytest.mark.parametrize("seed", range(3))
def test_a_larger_residual_never_costs_less(score, seed):
    residuals, scale, matched = random_match(seed)
    before = match_cost(score, residuals, scale, matched)
    for k in np.flatnonzero(matched):
        assert match_cost(score, residuals + np.eye(9)[k] * 5, scale, matched) >= before


@match_scores
@pytest.mark.parametrize("seed", range(3))
def test_markers_without_a_match_do_not_matter(score, seed):
    residuals, scale, matched = random_match(seed)
    other = np.where(matched, scale, 1e-6)
    expected = match_cost(score, residuals, scale, matched)
    np.testing.assert_allclose(match_cost(score, residuals, other, matched), expected, rtol=1e-6)
    np.testing.assert_allclose(match_cost(score, residuals[:6], scale[:6], matched[:6]), expected, rtol=1e-6)


@match_scores
def test_the_order_of_markers_and_the_unit_do_not_matter(score):
    residuals, scale, matched = random_match(1)
    expected = match_cost(score, residuals, scale, matched)
    order = np.random.default_rng(0).permutation(9)
    np.testing.assert_allclose(match_cost(score, residuals[order], scale[order], matched[order]), expected, rtol=1e-5)
    np.testing.assert_allclose(match_cost(score, residuals / 1000, scale / 1000, matched), expected, rtol=1e-5)


@match_scores
def test_nothing_matched_gives_no_nan(score):
    assert not np.isnan(match_cost(score, np.zeros(9), np.ones(9), np.zeros(9)))


@pytest.mark.parametrize("seed", range(3))
def test_mean_rms_and_max_come_in_this_order(seed):
    costs = [match_cost(s(), *random_match(seed)) for s in (scoring.MeanResidual, scoring.RmsResidual)]
    assert costs[0] < costs[1] < match_cost(scoring.MaxResidual(), *random_match(seed))


class _NaNCandidate(scoring.AbstractCandidateScore):
    def __call__(self, model_distance, data_distance, tolerance):
        return (model_distance - data_distance) / (model_distance - data_distance)


class _NaNMatch(scoring.AbstractMatchScore):
    def __call__(self, residuals, scale, matched):
        return jnp.sqrt(-jnp.sum(residuals / scale))


@pytest.mark.parametrize(
    "scores", [{"candidate_score": _NaNCandidate()}, {"match_score": _NaNMatch()}], ids=["candidate", "match"]
)
def test_a_score_that_returns_nan_is_refused_by_name(scores):
    (score,) = scores.values()
    with pytest.raises(ValueError, match=f"{type(score).__name__} returned NaN"):
        Driver(**scores)


class _Branching(scoring.AbstractCandidateScore):
    def __call__(self, model_distance, data_distance, tolerance):
        return 0.0 if model_distance < data_distance else 1.0


class _Whole(scoring.AbstractMatchScore):
    def __call__(self, residuals, scale, matched):
        return residuals / scale


class _Counting(scoring.AbstractMatchScore):
    def __call__(self, residuals, scale, matched):
        return jnp.sum(matched)


@pytest.mark.parametrize(
    ("scores", "wrong"),
    [
        (
            {"candidate_score": _Branching()},
            r"_Branching failed with TracerBoolConversionError.*jnp.where instead of if",
        ),
        ({"match_score": _Whole()}, r"_Whole returned an array of shape \(4,\); a score must return one number"),
        ({"match_score": _Counting()}, "_Counting returned int"),
    ],
    ids=["failing", "array", "integer"],
)
def test_a_score_that_cannot_be_used_is_refused_by_name(scores, wrong):
    with pytest.raises(ValueError, match=wrong):
        Driver(**scores)


def test_one_bad_marker_raises_the_robust_score_least():
    residuals = np.array([1.0, 1.5, 1.2, 0.9, 40.0])
    arrays = residuals, np.full(5, 5.0), np.ones(5, bool)
    robust, mean = (match_cost(s(), *arrays) for s in (scoring.RobustResidual, scoring.MeanResidual))
    assert robust < 0.6 < 1 < mean


@match_scores
def test_the_driver_scores_fits_of_the_host_as_the_kernel_does(score):
    from dshpm_jax._requests import ScoreMatch

    def control():
        return (yield ScoreMatch(*random_match(0)))

    (found,) = Driver(match_score=score).run([control()])
    np.testing.assert_allclose(found, match_cost(score, *random_match(0)), rtol=1e-5)
