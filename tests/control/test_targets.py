"""Segments as the matcher sees them."""

import numpy as np

from dshpm_jax import Recording, Settings, SubjectModel
from dshpm_jax._control.targets import make_targets, symmetries
from dshpm_jax._geometry import pair_distances
from dshpm_jax._requests import Target
from dshpm_jax.synthesis import hand


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


def test_markers_never_seen_together_are_where_the_shape_has_them():
    """A model of two days, on each of which another marker of a segment was not worn."""
    takes, segment = [hand(frames=300, seed=seed) for seed in (1, 2)], "palm"
    left_out = [list(takes[0].segments[segment]["markers"])[k] for k in (0, 1)]
    worn = [without(take.recording, marker) for take, marker in zip(takes, left_out, strict=True)]
    whole, parted = (
        SubjectModel.from_recordings(recordings, takes[0].segments)
        for recordings in ([take.recording for take in takes], worn)
    )
    known, found = (
        next(t for t in make_targets(model, Settings()) if model.segments[t.segment].name == segment)
        for model in (whole, parted)
    )
    order = [parted.markers.index(whole.markers[m]) for m in known.markers]
    order = [found.markers.tolist().index(m) for m in order]
    assert np.isfinite(found.tolerance).all() and np.isfinite(found.scale).all() and np.isfinite(found.reach).all()
    np.testing.assert_allclose(found.distance[np.ix_(order, order)], known.distance, atol=6.0)
    np.testing.assert_allclose(found.tolerance[np.ix_(order, order)], known.tolerance, atol=10.0)


def without(recording: Recording, marker: str) -> Recording:
    kept = [k for k, label in enumerate(recording.labels) if label != marker]
    return Recording(recording.points[:, kept], tuple(recording.labels[k] for k in kept), recording.rate)
