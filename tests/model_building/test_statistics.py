"""Pair statistics: trimming, pooling, pairs that are never seen together."""

import numpy as np

from dshpm_jax._model_building.expectation import expected_spread
from dshpm_jax._model_building.statistics import pair_statistics


def clip(distances: np.ndarray) -> np.ndarray:
    """Two markers at the given distances (mm)."""
    points = np.zeros((len(distances), 2, 3))
    points[:, 1, 0] = distances
    return points


def test_a_few_wrong_hand_labels_do_not_count():
    distances = 100 + np.sin(np.arange(500))
    wrong = distances.copy()
    wrong[[100, 200, 300]] = 400
    one, other = (pair_statistics([clip(d)], [100.0]) for d in (distances, wrong))
    assert abs(one.spread[0, 1] - other.spread[0, 1]) < 0.05


def test_a_long_static_does_not_drown_a_short_motion():
    motion = clip(100 + 20 * np.sin(np.arange(120)))
    static = clip(np.full(900, 100.0))
    both = pair_statistics([static, motion], [100.0, 100.0])
    alone = pair_statistics([motion], [100.0])
    assert both.spread[0, 1] > 0.9 * alone.spread[0, 1]


def test_recordings_that_disagree_spread_the_pair():
    rng = np.random.default_rng(0)
    clips = [clip(d + rng.normal(size=200)) for d in (100.0, 110.0)]
    assert 4 < pair_statistics(clips, [100.0, 100.0]).spread[0, 1] < 6


def test_pairs_never_seen_together_are_unknown():
    points = np.concatenate([clip(np.full(20, 50.0)), clip(np.full(20, 60.0))[:, 1:]], axis=1)
    points[:10, 1] = np.nan
    points[10:, 2] = np.nan
    found = pair_statistics([points], [100.0])
    assert np.isnan(found.mean[1, 2]) and found.evidence[1, 2] == 0
    assert 0 < found.evidence[0, 1] < 0.5 and found.mean[0, 2] == 60


def test_a_single_frame_expects_what_bodies_do():
    found = pair_statistics([clip(np.full(1, 200.0))], [100.0])
    same, across = (expected_spread(found, names)[0, 1] for names in (("LTIB", "LSHN"), ("LTHI", "LTIB")))
    assert 2 <= same < 5 < across
