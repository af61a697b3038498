"""What must not change a label: the order of columns and files, the place of the room, units, padding, batches."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from takes import METHODS, model, shares, take, take_for

from dshpm_jax import Recording, io
from dshpm_jax._driver import Driver
from dshpm_jax._label import label, label_many
from dshpm_jax._settings import Settings

methods = pytest.mark.parametrize("method", METHODS)
SEED = 3


@cache
def identities(method: str, seed: int = SEED) -> np.ndarray:
    return label_as(method, take_for(method, seed))


def label_as(method: str, recording: Recording) -> np.ndarray:
    return label(recording, model(), Settings(method=method)).identities


def reordered(recording: Recording, order) -> Recording:
    return Recording(recording.points[:, order], tuple(recording.labels[k] for k in order), recording.rate)


def moved(recording: Recording, turn: np.ndarray, shift: np.ndarray) -> Recording:
    return replace(recording, points=recording.points @ turn.T + shift)


@pytest.mark.parametrize(("method", "least"), [("full", 0.98), ("paper", 0.8), ("static", 0.75)])
def test_most_labels_are_right(method, least):
    """Guards the others: a law that holds because nothing is ever labelled, or all of it wrongly, says nothing."""
    recording, (_, truth) = take_for(method, SEED), take(SEED)
    right, wrong = shares(identities(method), recording, truth)
    assert right > least and wrong < 0.05


@methods
def test_the_order_of_columns(method):
    recording = take_for(method, SEED)
    order = np.random.default_rng(0).permutation(recording.points.shape[1])
    np.testing.assert_array_equal(label_as(method, reordered(recording, order)), identities(method)[:, order])


@methods
def test_the_place_of_the_room(method):
    turn = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    turned = moved(take_for(method, SEED), turn, np.array([3000.0, -1500.0, 700.0]))
    np.testing.assert_array_equal(label_as(method, turned), identities(method))


@settings(max_examples=5, derandomize=True)
@given(st.integers(0, 2**31), st.lists(st.floats(-5000, 5000), min_size=3, max_size=3))
@example(0, [0.0, 0.0, 0.0])
def test_any_motion_of_the_room(seed, shift):
    turn = Rotation.random(random_state=seed).as_matrix()
    turned = moved(take_for("paper", SEED), turn, np.array(shift))
    np.testing.assert_array_equal(label_as("paper", turned), identities("paper"))


@methods
def test_the_unit_of_the_file(method, tmp_path):
    found = {}
    for unit in ("mm", "m"):
        recording = replace(take_for(method, SEED), unit=unit)
        io.write_c3d(recording, tmp_path / f"{unit}.c3d")
        again = io.read(tmp_path / f"{unit}.c3d")
        assert again.unit == unit and again.points.shape == recording.points.shape
        found[unit] = label_as(method, again)
    np.testing.assert_array_equal(found["m"], found["mm"])
    np.testing.assert_array_equal(found["mm"], identities(method))


@methods
def test_empty_columns(method):
    recording = take_for(method, SEED)
    empty = np.full((recording.num_frames, 30, 3), np.nan)
    wider = Recording(
        np.concatenate([empty[:, :10], recording.points, empty[:, 10:]], axis=1),
        tuple(f"*{k}" for k in range(recording.points.shape[1] + 30)),
        recording.rate,
    )
    found = label_as(method, wider)
    np.testing.assert_array_equal(found[:, 10:-20], identities(method))
    assert (found[:, :10] == -1).all() and (found[:, -20:] == -1).all()


@methods
@pytest.mark.parametrize("in_flight", [2, 64])
def test_company_in_the_batch(method, in_flight):
    seeds = [SEED + 1, SEED]
    recordings = [take_for(method, seed) for seed in seeds]
    found = label_many(recordings, model(), Settings(method=method), Driver(in_flight=in_flight))
    for recording, seed, labelling in zip(recordings, seeds, found, strict=True):
        assert labelling.recording is recording
        np.testing.assert_array_equal(labelling.identities, identities(method, seed))


def test_the_order_of_recordings():
    recordings = [take_for("paper", seed) for seed in range(4)]
    ahead, back = (list(label_many(r, model(), Settings(method="paper"))) for r in (recordings, recordings[::-1]))
    for one, other in zip(ahead, back[::-1], strict=True):
        np.testing.assert_array_equal(one.identities, other.identities)


@methods
def test_names_that_are_there_already(method):
    recording = take_for(method, SEED)
    names = tuple(model().markers[k % 34] for k in range(len(recording.labels)))
    np.testing.assert_array_equal(label_as(method, replace(recording, labels=names)), identities(method))


@methods
def test_a_marker_is_in_one_place_at_a_time(method):
    for row in identities(method):
        named = row[row != -1]
        assert len(named) == len(set(named.tolist()))


def test_the_input_stays_as_it_is():
    recording, _ = take(SEED)
    before = recording.points.copy()
    label_as("full", recording)
    np.testing.assert_array_equal(recording.points, before)
