"""One assignment for the recording: the best of all that give no label twice in a frame."""

from itertools import product

import numpy as np
import pytest

from dshpm_jax._control.full.assignment import assign_labels
from dshpm_jax._types import NO_MATCH


def is_legal(identity, start, stop) -> bool:
    for a, b in product(range(len(identity)), repeat=2):
        if a < b and identity[a] == identity[b] != NO_MATCH and start[a] < stop[b] and start[b] < stop[a]:
            return False
    return True


def worth(identity, gain) -> float:
    return sum(gain[j, m] for j, m in enumerate(identity) if m != NO_MATCH)


@pytest.mark.parametrize("seed", range(15))
def test_the_best_of_all_assignments(seed):
    rng = np.random.default_rng(seed)
    gain = rng.normal(0, 10, (5, 3))
    start = rng.integers(0, 20, 5)
    stop = start + rng.integers(1, 20, 5)
    found = assign_labels(gain, start, stop)
    assert is_legal(found, start, stop)
    every = product([NO_MATCH, 0, 1, 2], repeat=5)
    best = max(worth(identity, gain) for identity in every if is_legal(identity, start, stop))
    assert worth(found, gain) == pytest.approx(best)
    assert all(gain[j, m] > 0 for j, m in enumerate(found) if m != NO_MATCH)


def test_where_halves_would_be_worth_more_the_best_of_whole_numbers():
    gain = np.array([[2, 2, 2], [3, 3, 3], [2, 3, 3], [2, 2, 1], [1, 3, 2]], float)
    start, stop = np.array([2, 1, 2, 3, 2]), np.array([3, 6, 3, 4, 4])
    found = assign_labels(gain, start, stop)
    assert is_legal(found, start, stop)
    every = product([NO_MATCH, 0, 1, 2], repeat=5)
    assert worth(found, gain) == max(worth(identity, gain) for identity in every if is_legal(identity, start, stop))


def test_one_label_may_go_to_trajectories_one_after_the_other():
    start, stop = np.array([0, 10, 20]), np.array([10, 20, 30])
    assert assign_labels(np.ones((3, 1)), start, stop).tolist() == [0, 0, 0]
    assert (assign_labels(np.ones((3, 1)), start, stop + 1) == 0).sum() == 2


def test_nothing_to_gain_is_nothing_labelled():
    start, stop = np.zeros(4, int), np.ones(4, int)
    assert (assign_labels(-np.ones((4, 3)), start, stop) == NO_MATCH).all()
    assert (assign_labels(np.zeros((4, 0)), start, stop) == NO_MATCH).all()
    assert assign_labels(np.zeros((0, 3)), start[:0], stop[:0]).shape == (0,)


@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_trajectories_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    gain, start = rng.normal(0, 10, (30, 8)), rng.integers(0, 50, 30)
    stop, order = start + rng.integers(1, 30, 30), rng.permutation(30)
    found = assign_labels(gain, start, stop)
    np.testing.assert_array_equal(assign_labels(gain[order], start[order], stop[order]), found[order])
