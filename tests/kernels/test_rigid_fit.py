"""The rigid fit against a float64 SVD, on clean, degenerate and mirrored point sets."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import reference
from equinox.debug import assert_max_traces
from hypothesis import given, settings
from hypothesis import strategies as st

from dshpm_jax._kernels.rigid_fit import CHUNK_LANES, MIN_SPREAD, rigid_fit, rigid_fit_lanes

FITS, MARKERS = 100, 6
RMS_TOLERANCE = 1e-3  # millimetres, float32
TURN_TOLERANCE = 5e-6

fit = jax.jit(rigid_fit)


def turns(rng, count):
    """Random rotations."""
    q, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    return q * np.sign(np.linalg.det(q))[:, None, None]


OCTAHEDRON = 100 * np.concatenate([np.eye(3), -np.eye(3)])

SHAPES = {
    "random": lambda rng: rng.normal(0, 100, (FITS, MARKERS, 3)),
    "coplanar": lambda rng: rng.normal(0, 100, (FITS, MARKERS, 3)) * [1, 1, 0],
    "collinear": lambda rng: rng.normal(0, 100, (FITS, MARKERS, 1)) * [1, 2, 3],
    "nearly collinear": lambda rng: rng.normal(0, 100, (FITS, MARKERS, 3)) * [1, 0.01, 0.001],
    "grains on a line": lambda rng: rng.normal(0, 100, (FITS, MARKERS, 3)) * [1, 3e-4, 3e-4],
    "coincident": lambda rng: np.broadcast_to(rng.normal(0, 100, (FITS, 1, 3)), (FITS, MARKERS, 3)),
    "symmetric": lambda rng: np.broadcast_to(OCTAHEDRON, (FITS, MARKERS, 3)),
    "lattice": lambda rng: 40.0 * rng.integers(-2, 3, (FITS, MARKERS, 3)),
}


@pytest.mark.parametrize("noise", [0, 5])
@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
def test_as_good_as_svd(shape, mirrored, noise):
    rng = np.random.default_rng(0)
    model = SHAPES[shape](rng)
    data = (model * ([1, 1, -1] if mirrored else 1)) @ turns(rng, FITS) + rng.normal(0, 500, (FITS, 1, 3))
    data += noise * rng.normal(size=data.shape)
    weights = rng.choice([0, 0.5, 1], (FITS, MARKERS), p=[0.2, 0.2, 0.6])
    data = np.where(weights[..., None] > 0, data, np.nan)
    check_against_svd(*(x.astype(np.float32) for x in (model, data, weights)))


@pytest.mark.parametrize("seed", range(10))
def test_integer_points_tie_everywhere(seed):
    rng = np.random.default_rng(seed)
    model, data = (40 * rng.integers(-1, 2, (FITS, MARKERS, 3)).astype(np.float32) for _ in range(2))
    check_against_svd(model, data, np.ones((FITS, MARKERS), np.float32))


def check_against_svd(model, data, weights):
    found = jax.device_get(fit(model, data, weights))
    check_rotations(found.rotation)
    for k in range(len(model)):
        rotation, _, rms = reference.rigid_fit(model[k], data[k], weights[k])
        ours = reference.fit_rms(found.rotation[k], found.translation[k], model[k], data[k], weights[k])
        assert ours == pytest.approx(rms, abs=RMS_TOLERANCE)
        assert found.rms[k] == pytest.approx(rms, abs=RMS_TOLERANCE)


def check_rotations(rotation):
    rotation = np.asarray(rotation, np.float64)
    assert np.abs(rotation @ np.swapaxes(rotation, -1, -2) - np.eye(3)).max() < TURN_TOLERANCE
    assert np.abs(np.linalg.det(rotation) - 1).max() < TURN_TOLERANCE


def test_double_precision_recovers_the_rotation():
    rng = np.random.default_rng(2)
    model, turn = rng.normal(0, 100, (FITS, MARKERS, 3)), turns(rng, FITS)
    data = np.einsum("bij,bmj->bmi", turn, model) + 1000
    with jax.enable_x64(True):
        found = jax.jit(rigid_fit)(model, data, np.ones((FITS, MARKERS)))
        assert found.rotation.dtype == jnp.float64
    np.testing.assert_allclose(found.rotation, turn, atol=1e-7)  # three sweeps are meant for single precision
    np.testing.assert_allclose(found.translation, 1000, atol=1e-4)


def test_rank_counts_the_directions_of_spread():
    shapes = {0: [1, 1, 1], 1: [100, 1, 1], 2: [100, 100, 1], 3: [100, 100, 100]}
    rng = np.random.default_rng(3)
    box = rng.permuted(np.tile([-1.0, 1.0], (3, 8)), axis=1).T  # RMS 1 along each axis
    for rank, spread in shapes.items():
        model = (box * spread).astype(np.float32)
        assert fit(model, model, np.ones(len(model), np.float32)).rank == rank


def test_two_points_have_no_pose():
    model = np.array([[0, 0, 0], [100, 0, 0], [0, 100, 0], [0, 0, 100]], np.float32)
    assert fit(model, model, np.array([1, 1, 0, 0], np.float32)).rank == 1
    assert fit(model, model, np.array([1, 1, 1, 0], np.float32)).rank == 2


def test_the_spread_asked_for_is_a_parameter():
    model = np.array([[-50, 0, 0], [50, 0, 0], [0, 12, 0], [0, -12, 0]], np.float32)
    weights = np.ones(4, np.float32)
    assert fit(model, model, weights, 8.0).rank == 2
    assert fit(model, model, weights).rank == 1
    assert MIN_SPREAD == 12


def test_nothing_to_fit():
    nothing = np.full((FITS, MARKERS, 3), np.nan, np.float32)
    found = fit(nothing, nothing, np.zeros((FITS, MARKERS), np.float32))
    check_rotations(found.rotation)
    for value in (found.translation, found.rms, found.rank):
        np.testing.assert_array_equal(value, 0)


values = st.floats(-1e4, 1e4, width=32) | st.sampled_from([0.0, 1.0, -1.0, np.nan, np.inf, 3e38])
points = st.lists(values, min_size=12, max_size=12).map(lambda x: np.array(x, np.float32).reshape(4, 3))


@settings(max_examples=100)
@given(points, points, st.lists(st.sampled_from([0.0, 0.25, 1.0]), min_size=4, max_size=4))
def test_always_a_rotation(model, data, weights):
    found = fit(model, data, np.array(weights, np.float32))
    assert all(np.isfinite(x).all() for x in found)
    check_rotations(found.rotation[None])


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_moving_the_data_moves_the_fit(seed):
    rng = np.random.default_rng(seed)
    model, data = rng.normal(0, 100, (2, 4, 3)).astype(np.float32)
    turn, shift = turns(rng, 1)[0].astype(np.float32), rng.normal(0, 100, 3).astype(np.float32)
    before = fit(model, data, np.ones(4, np.float32))
    after = fit(model, data @ turn.T + shift, np.ones(4, np.float32))
    assert after.rms == pytest.approx(float(before.rms), abs=RMS_TOLERANCE)


def test_neighbours_in_a_batch_do_not_matter():
    rng = np.random.default_rng(4)
    lanes = 2 * CHUNK_LANES + 7
    model, data = (rng.normal(0, 100, (lanes, 4, 3)).astype(np.float32) for _ in range(2))
    weights = rng.choice([0, 1], (lanes, 4)).astype(np.float32)
    together = fit(model, data, weights)
    for k in (0, CHUNK_LANES, lanes - 1):
        alone = fit(model[k], data[k], weights[k])
        np.testing.assert_allclose(together.rms[k], alone.rms, atol=1e-4)
        assert together.rank[k] == alone.rank


def test_layouts_and_vmap_agree():
    rng = np.random.default_rng(5)
    model, data = (rng.normal(0, 100, (FITS, MARKERS, 3)).astype(np.float32) for _ in range(2))
    weights = np.ones((FITS, MARKERS), np.float32)
    batch, mapped = fit(model, data, weights), jax.jit(jax.vmap(rigid_fit))(model, data, weights)
    lanes = jax.jit(rigid_fit_lanes)(*(np.moveaxis(x, 0, -1) for x in (model, data, weights)))
    for a, b, c in zip(batch, mapped, lanes):
        np.testing.assert_allclose(a, b, atol=1e-3)
        np.testing.assert_allclose(a, np.moveaxis(np.asarray(c), -1, 0), atol=1e-3)


def test_one_program_a_shape():
    counted = jax.jit(assert_max_traces(rigid_fit, max_traces=1))
    for spread in (8.0, 12.0):
        model = np.ones((FITS, MARKERS, 3), np.float32)
        counted(model, model, np.ones((FITS, MARKERS), np.float32), spread)
