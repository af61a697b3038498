"""Values that kernels compute once: they are the same, and XLA does keep them apart from their uses."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from dshpm_jax._kernels.fusing import all_finite, opaque_true, square_length, stored, total


def halved(values, weights):
    """Something whose parts XLA would otherwise fuse."""
    means = stored(opaque_true(weights), lambda x: (x + x[::-1]) / 2, values)
    return means[:, None] * values[None]


@pytest.mark.parametrize("first", [0.0, 1.0, np.nan, np.inf])
def test_what_is_stored_is_what_was_computed(first):
    values, weights = np.arange(4, dtype=np.float32), np.array([first, 0, 1], np.float32)
    expected = (values + values[::-1])[:, None] / 2 * values
    np.testing.assert_array_equal(jax.jit(halved)(values, weights), expected)
    np.testing.assert_array_equal(jax.jit(jax.vmap(halved))(values[None], weights[None]), expected[None])


def test_no_weights_at_all():
    assert opaque_true(jnp.zeros((0, 3)))


@pytest.mark.skipif(jax.default_backend() != "cpu", reason="other devices fuse as they like")
def test_the_condition_is_still_there_when_compiled():
    program = jax.jit(halved).lower(np.ones(4, np.float32), np.ones(3, np.float32)).compile()
    assert "conditional(" in program.as_text()


def test_sums_written_out():
    vectors = np.random.default_rng(0).normal(size=(5, 3, 7)).astype(np.float32)
    np.testing.assert_allclose(total(jnp.asarray(vectors)), vectors.sum(0), rtol=1e-5)
    np.testing.assert_allclose(square_length(jnp.asarray(vectors)), (vectors**2).sum(1), rtol=1e-5)
    vectors[2, 1, 3], vectors[4, 0, 0] = np.nan, np.inf
    np.testing.assert_array_equal(all_finite(jnp.asarray(vectors)), np.isfinite(vectors).all(1))
