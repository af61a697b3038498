"""Plain numpy geometry against slow and obvious counterparts."""

from itertools import pairwise

import numpy as np
import pytest
from moving import moving

from dshpm_jax._geometry import (
    evenly_inside,
    evenly_spaced,
    every_nth,
    is_seen,
    pair_distances,
    predict_last,
    rigid_fit,
    runs,
    weighted_rigid_fit,
)


def moved(rotation: np.ndarray, translation: np.ndarray, body: np.ndarray) -> np.ndarray:
    return np.einsum("fij,mj->fmi", rotation, body) + translation[:, None]


def test_a_point_is_seen_with_all_of_its_coordinates():
    points = np.zeros((2, 3, 3))
    points[0, 1, 2], points[1, 0, 0], points[1, 2] = np.nan, np.inf, np.nan
    assert is_seen(points).tolist() == [[True, False, True], [False, True, False]]


def test_runs_are_half_open_and_reach_both_ends():
    assert runs(np.array([1, 1, 0, 0, 1, 0, 1], bool)) == [(0, 2), (4, 5), (6, 7)]
    assert runs(np.zeros(3, bool)) == runs(np.zeros(0, bool)) == []


@pytest.mark.parametrize("rounded", [False, True])
@pytest.mark.parametrize("most", [1, 2, 7, 60])
def test_evenly_spaced_numbers(most, rounded):
    for count in (0, 1, 2, 3, 7, 8, 59, 60, 61, 119, 500):
        picked = evenly_spaced(count, most, rounded).tolist()
        assert len(picked) == min(count, most)
        if count <= most:
            assert picked == list(range(count))
        elif most > 1:
            steps = [b - a for a, b in pairwise(picked)]
            assert (picked[0], picked[-1]) == (0, count - 1) and min(steps) >= 1 and max(steps) - min(steps) <= 2


def test_evenly_spaced_numbers_are_below_or_nearest_to_their_places():
    assert evenly_spaced(6, 4).tolist() == [0, 1, 3, 5]  # of 0, 1.67, 3.33, 5
    assert evenly_spaced(6, 4, rounded=True).tolist() == [0, 2, 3, 5]


def test_numbers_inside_leave_the_ends_out_where_there_are_more():
    assert evenly_inside(9, 3).tolist() == [2, 4, 6]
    assert evenly_inside(3, 7).tolist() == [0, 1, 2] and evenly_inside(1, 7).tolist() == [0]
    assert evenly_inside(0, 7).tolist() == []


def test_every_nth_has_one_step_and_begins_with_the_first():
    numbers = np.arange(500)
    for count, most in ((0, 5), (1, 5), (6, 5), (11, 5), (7, 7), (500, 60)):
        picked = numbers[:count][every_nth(count, most)]
        assert len(picked) <= most and len(set(np.diff(picked))) <= 1 and picked[:1].tolist() == [0][:count]


def test_distances_of_pairs_alone_and_in_frames():
    _, points = moving(3, frames=2)
    slow = [[np.linalg.norm(a - b) for b in points[1]] for a in points[1]]
    np.testing.assert_allclose(pair_distances(points[1]), slow)
    np.testing.assert_array_equal(pair_distances(points)[1], pair_distances(points[1]))


def test_poses_need_three_points_off_a_line():
    body, points = moving(2)
    points[0, 2:] = np.nan
    rotation, translation = rigid_fit(body, points)
    assert np.isnan(rotation[0]).all() and np.isfinite(rotation[1:]).all()
    np.testing.assert_allclose(np.linalg.det(rotation[1:]), 1)
    np.testing.assert_allclose(moved(rotation, translation, body)[1:], points[1:], atol=1e-8)
    line = np.outer(np.arange(4.0), [10, 0, 0])
    assert np.isnan(rigid_fit(line, line[None])[0]).all()


def test_a_marker_without_a_place_in_the_shape_takes_no_part():
    body, points = moving(4)
    body[0] = np.nan
    rotation, translation = rigid_fit(body, points)
    np.testing.assert_allclose(moved(rotation, translation, body[1:]), points[:, 1:], atol=1e-8)


def test_with_equal_weights_the_weighted_fit_is_the_plain_one():
    body, points = moving(5)
    points += np.random.default_rng(6).normal(0, 3, points.shape)
    points[::3, 1] = np.nan
    plain = rigid_fit(body, points)
    *weighted, spread = weighted_rigid_fit(body, points, np.full(points.shape[:2], 0.25))
    for one, other in zip(plain, weighted):
        np.testing.assert_allclose(one, other, atol=1e-8)
    assert (spread > 10).all()


def test_a_weight_says_how_much_a_point_pulls():
    body, points = moving(7)
    wrong = points.copy()
    wrong[:, 0] += 100
    rotation, translation, _ = weighted_rigid_fit(body, wrong, np.array([1e-9, 1, 1, 1, 1]) * np.ones((len(points), 1)))
    np.testing.assert_allclose(moved(rotation, translation, body), points, atol=1e-3)


def test_the_last_place_is_predicted_from_the_others():
    body, points = moving(8)
    found = predict_last(body, points[:, :-1], np.ones(len(body) - 1))
    np.testing.assert_allclose(found, points[:, -1], atol=1e-8)


def test_points_in_a_line_spread_across_it_by_nothing():
    line = np.outer(np.arange(4.0), [10, 0, 0])
    assert weighted_rigid_fit(line, line[None], np.ones((1, 4)))[2] < 1e-3
