"""Poses between given ones: with the parent where that is known, else in the world."""

import numpy as np
from scipy.spatial.transform import Rotation

from dshpm_jax._model import Segment, VirtualJoin
from dshpm_jax._reconstruction.interpolation import interpolate
from dshpm_jax._reconstruction.rigid import SegmentPoses

FRAMES = 500
CORNERS = np.array([[0.0, 0, 0], [100, 0, 0], [0, 100, 0]])
THIGH = Segment("thigh", (0, 1, 2), CORNERS)
KNEE = VirtualJoin(np.array([0.0, 0, -500]), np.zeros(3), 1.0)
SHANK = Segment("shank", (3, 4, 5), CORNERS, parent=0, virtual_join=KNEE)


def two_segments() -> SegmentPoses:
    """The parent swings, and the child swings with it, half a metre away, where their joint is."""
    swing = 1.2 * np.sin(np.arange(FRAMES) / 30)
    turned = Rotation.from_rotvec(np.outer(swing, [1.0, 0, 0])).as_matrix()
    moved = np.linspace(0, 2000, FRAMES)[:, None] * np.array([1.0, 0, 0])
    away = turned @ np.array([0, 0, -500.0])
    return SegmentPoses(np.stack([turned, turned], 1), np.stack([moved, moved + away], 1))


def error(truth: SegmentPoses, lost: slice) -> float:
    """Of the child (mm), which is not seen for 18 frames, with the parent not seen in `lost`."""
    given = np.ones((FRAMES, 2), bool)
    given[lost, 0] = given[240:258, 1] = False
    seen = SegmentPoses(*(np.where(given.reshape(FRAMES, 2, *(1,) * (x.ndim - 2)), x, np.nan) for x in truth))
    way = interpolate((THIGH, SHANK), seen, given, 60.0)
    return float(np.linalg.norm(way.poses.translations[:, 1] - truth.translations[:, 1], axis=-1).max())


def test_a_child_goes_with_a_parent_that_is_known():
    assert error(two_segments(), slice(0, 0)) < 1e-6


def test_a_child_does_not_hang_on_a_parent_that_is_long_lost():
    assert error(two_segments(), slice(100, 400)) < 40.0
