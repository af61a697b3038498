"""Eqs. 1 and 2 against loops over pairs and frames."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import reference
from equinox.debug import assert_max_traces

from dshpm_jax._kernels.pair_statistics import pair_statistics, segmentation_matrices, segmentation_matrix

FRAMES, POINTS = 11, 12
EXTENT, RATIO = 300.0, 0.1

segment = jax.jit(segmentation_matrix)


def windows(count, seed=0):
    """Points of which some move together and some do not, with gaps; NaN where missing."""
    rng = np.random.default_rng(seed)
    rest = rng.uniform(0, 400, (count, 1, POINTS, 3))
    own = rng.normal(0, 1, (count, FRAMES, POINTS, 3)) * rng.choice([1.0, 60.0], (count, 1, POINTS, 1))
    present = rng.random((count, FRAMES, POINTS)) < rng.choice([1.0, 0.7, 0.2, 0.0], (count, 1, POINTS))
    points = rest + own + rng.normal(0, 500, (count, FRAMES, 1, 3))
    return np.where(present[..., None], points, np.nan).astype(np.float32), present


@pytest.mark.parametrize("seed", range(5))
def test_as_by_loops(seed):
    (window,), (present,) = windows(1, seed)
    expected = reference.segmentation_matrix(window, present, EXTENT, RATIO)
    assert 0 < expected.sum() < POINTS * (POINTS - 1)
    np.testing.assert_array_equal(segment(window, present, EXTENT, RATIO), expected)


def test_many_windows_at_once():
    window, present = windows(6)
    extent, ratio = np.full(6, EXTENT, np.float32), np.full(6, RATIO, np.float32)
    together = jax.jit(segmentation_matrices)(window, present, extent, ratio)
    mapped = jax.jit(jax.vmap(segmentation_matrix))(window, present, extent, ratio)
    np.testing.assert_array_equal(together, mapped)
    np.testing.assert_array_equal(together[3], segment(window[3], present[3], EXTENT, RATIO))


def test_too_few_frames_leave_a_pair_possible():
    window = np.zeros((FRAMES, 2, 3), np.float32)
    window[:, 1, 0] = np.arange(FRAMES) * 1000
    present = np.ones((FRAMES, 2), bool)
    assert not segment(window, present, EXTENT, RATIO)[0, 1]
    present[2:, 1] = False
    assert segment(window, present, EXTENT, RATIO)[0, 1]


def test_a_point_that_is_never_seen_pairs_with_none():
    (window,), (present,) = windows(1)
    present = present.copy()
    present[:, 3] = False
    found = segment(window, present, EXTENT, RATIO)
    assert not found[3].any() and not found[:, 3].any()


def test_statistics_far_from_the_origin():
    (window,), _ = windows(1)
    window = np.nan_to_num(window) + np.float32(5000)
    found = jax.jit(pair_statistics)(jnp.asarray(window), jnp.ones((FRAMES, POINTS), bool))
    exact = np.linalg.norm(window[:, :, None].astype(np.float64) - window[:, None], axis=-1)
    np.testing.assert_allclose(found.mean, exact.mean(0), atol=0.01)
    np.testing.assert_allclose(found.smallest, exact.min(0), atol=0.01)
    np.testing.assert_allclose(found.largest, exact.max(0), atol=0.01)
    np.testing.assert_array_equal(found.num_frames, FRAMES)


def test_padding_changes_nothing():
    (window,), (present,) = windows(1)
    padded = np.full((FRAMES, 32, 3), np.nan, np.float32)
    padded[:, :POINTS] = window
    seen = np.zeros((FRAMES, 32), bool)
    seen[:, :POINTS] = present
    found = segment(padded, seen, EXTENT, RATIO)
    np.testing.assert_array_equal(found[:POINTS, :POINTS], segment(window, present, EXTENT, RATIO))
    assert not found[POINTS:].any()


def test_limits_do_not_recompile():
    counted = jax.jit(assert_max_traces(segmentation_matrix, max_traces=1))
    (window,), (present,) = windows(1)
    for extent in (100.0, 200.0, 300.0):
        counted(window, present, extent, RATIO)
