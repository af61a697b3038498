"""Neighbourhoods: the markers that predict a marker's place, and how well."""

import numpy as np

from dshpm_jax._model_building.neighbours import build_neighbourhoods
from dshpm_jax._model_building.statistics import pair_statistics

NAMES = tuple(f"m{k}" for k in range(10))


def two_bodies(frames: int = 300, noise: float = 0.5):
    """Two rigid bodies of five markers that turn about a common joint."""
    rng = np.random.default_rng(0)
    shapes = rng.uniform(-150, 150, (2, 5, 3))
    angle = np.sin(np.linspace(0, 12, frames))
    cos, sin, one, zero = np.cos(angle), np.sin(angle), np.ones(frames), np.zeros(frames)
    turn = np.stack([cos, -sin, zero, sin, cos, zero, zero, zero, one], -1).reshape(-1, 3, 3)
    first = np.broadcast_to(shapes[0], (frames, 5, 3))
    second = np.einsum("fij,mj->fmi", turn, shapes[1] + [250.0, 0, 0])
    return np.concatenate([first, second], axis=1) + rng.normal(0, noise, (frames, 10, 3))


def build(points):
    return build_neighbourhoods(NAMES, [points], pair_statistics([points], [100.0]))


def test_a_marker_is_predicted_by_its_own_body_first():
    for marker, found in enumerate(build(two_bodies())):
        assert {m // 5 for m in found.markers[:4]} == {marker // 5}
        assert marker not in found.markers
        assert (np.diff(found.distance_sd) >= 0).all()


def test_a_rigid_body_predicts_well_and_a_soft_one_says_so():
    points = two_bodies()
    rigid = [found.marker_sd for found in build(points)]
    points[:, 7] += 25 * np.sin(np.linspace(0, 20, len(points)))[:, None]
    soft = [found.marker_sd for found in build(points)]
    assert np.median(rigid) < 12.0
    assert soft[7] > max(15.0, 1.5 * rigid[7])


def test_markers_never_seen_together_and_single_frames_still_have_neighbours():
    points = two_bodies(60)
    points[:30, 4], points[30:, 3] = np.nan, np.nan
    for frames in (points, points[:1]):
        for found in build(frames):
            assert np.isfinite(found.marker_sd) and np.isfinite(found.shape).all()
