"""Ranking, candidates and completion where numbers tie, and what is counted rather than kept."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from matching_cases import make_request
from reference import NO_MATCH

from dshpm_jax._driver.matching import pad
from dshpm_jax._kernels import candidate_table as ct
from dshpm_jax._kernels.completion import COMPLETIONS, complete
from dshpm_jax._scoring import ToleranceScore

SCORE = ToleranceScore()


def padded(requests):
    """What the driver hands to the kernel, as it is inside of it."""
    return jax.tree.map(jnp.asarray, pad(requests))


@pytest.mark.parametrize("survivors", [0, 1, 8, 9, 64])
def test_few_and_many_survivors_are_ranked_alike(survivors):
    rng = np.random.default_rng(survivors)
    rank = np.full(64, ct.LAST, np.int32)
    chosen = rng.permutation(64)[:survivors]
    rank[chosen] = rng.integers(0, 3, survivors)
    error = rng.integers(0, 3, 64).astype(np.float32)
    order = jax.jit(ct._sort)(rank, error, survivors)
    expected = np.lexsort((np.arange(64), error, rank))
    assert np.asarray(order)[:survivors].tolist() == expected[:survivors].tolist()


def test_candidates_tie_by_index_and_the_rest_is_counted():
    """Points on a ring about the pivot all cost the same in a column."""
    asked = make_request(np.random.default_rng(0), 3, 40, missing=0.0)
    angle = np.linspace(0, 2, 40)
    asked.points[:] = 50 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
    asked.points[7] = 0.0
    asked.points[::2] *= 1.0001
    asked.free[:], asked.rigid[:] = True, True
    asked.target.distance[:], asked.target.tolerance[:] = 50.0, 10.0
    problems, _ = padded([asked])
    here = ct.Hypotheses(*(jnp.array([x]) for x in (0, 0, 7, True)))
    distances = jax.jit(ct.pivot_distances)(problems)
    assert np.isnan(distances.to_pinned).all()
    table = jax.jit(lambda: ct.order_candidates(problems, distances, here, SCORE))()
    cost = np.abs(np.asarray(distances.to_point)[0, 7] - 50.0) / 10.0
    expected = np.lexsort((np.arange(len(cost)), cost))[: ct.MAX_CANDIDATES]  # NaN comes last
    assert table[0, 0].tolist() == [7] + [NO_MATCH] * (ct.MAX_CANDIDATES - 1)
    assert table[1, 0].tolist() == table[2, 0].tolist() == expected.tolist()
    assert (np.asarray(table[3:]) == NO_MATCH).all()


def greedy(distance, assigned, rounds):
    """The nearest pair first, of equal ones the first column, then the first point."""
    distance, assigned = distance.copy(), assigned.copy()
    for _ in range(rounds):
        column, point = np.unravel_index(np.argmin(distance), distance.shape)
        if np.isinf(distance[column, point]):
            break
        assigned[column] = point
        distance[column], distance[:, point] = np.inf, np.inf
    return assigned


def test_completion_takes_the_nearest_pair_first_and_of_equal_ones_the_first():
    """Places on a coarse grid, so that most distances tie and columns want the same points."""
    rng = np.random.default_rng(2)
    problems, _ = padded([make_request(rng, 8, 60)])
    points = rng.integers(0, 4, problems.points[0].shape).astype(np.float32)
    free = rng.random(len(points)) < 0.7
    reach = np.array([0, 1, 1, 1.5, 2, 2, 3, 3], np.float32)
    problems = problems._replace(points=points[None], free=free[None], reach=reach[None])
    problems = jax.tree.map(jnp.asarray, problems)
    lanes = 64
    predicted = rng.integers(0, 4, (8, 3, lanes)).astype(np.float32)
    claimed = np.array([rng.permutation(60)[:8] for _ in range(lanes)]).T
    assigned = np.where(rng.random((8, lanes)) < 0.4, claimed, NO_MATCH).astype(np.int32)
    wanted = (assigned == NO_MATCH) & (rng.random((8, lanes)) < 0.9)
    request = jnp.zeros(lanes, jnp.int32)
    found = np.asarray(jax.jit(complete)(problems, request, predicted, assigned, wanted))
    for lane in range(lanes):
        distance = np.linalg.norm(predicted[:, None, :, lane] - points[None], axis=-1)
        near = (distance <= reach[:, None]) & wanted[:, lane][:, None] & free[None]
        near[:, assigned[:, lane][assigned[:, lane] != NO_MATCH]] = False
        expected = greedy(np.where(near, distance, np.inf), assigned[:, lane], COMPLETIONS)
        assert found[:, lane].tolist() == expected.tolist()
