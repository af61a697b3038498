"""Segments as the matcher sees them."""

import numpy as np

from dshpm_jax._control.targets import pair_distances, symmetries
from dshpm_jax._requests import Target


def target(shape: np.ndarray, tolerance: float) -> Target:
    size = len(shape)
    distance, ones = pair_distances(shape), np.ones(size)
    return Target(0, np.arange(size), shape, distance, np.full((size, size), tolerance), ones, ones, 3)


def test_two_markers_that_may_change_places_are_a_symmetry():
    """Front and back of a shoulder, each the other's nearest: no single exchange would be tried for them."""
    shape = np.array([[0.0, 0, 80], [0, 0, -70], [150, 10, 0], [300, 0, 0], [310, 40, 0]])
    assert symmetries(target(shape, 4.0)) == [(1, 0, 2, 3, 4)]
    assert symmetries(target(shape, 0.5)) == []


def test_a_rectangle_fits_four_ways():
    shape = np.array([[0.0, 0, 0], [100, 0, 0], [100, 60, 0], [0, 60, 0]])
    assert set(symmetries(target(shape, 4.0))) == {(1, 0, 3, 2), (2, 3, 0, 1), (3, 2, 1, 0)}
