"""Shapes of segments."""

import numpy as np
from moving import moving

from dshpm_jax._model_building.shapes import mean_shape


def distances(places: np.ndarray) -> np.ndarray:
    return np.linalg.norm(places[:, None] - places[None], axis=-1)


def handedness(places: np.ndarray) -> float:
    return float(np.sign(np.linalg.det(places[1:4] - places[0])))


def test_shape_and_handedness_are_found_although_never_all_are_seen():
    body, points = moving(0)
    points[np.arange(60), np.arange(60) % 5] = np.nan
    shape = mean_shape(points, distances(body))
    np.testing.assert_allclose(distances(shape), distances(body), atol=1e-6)
    assert handedness(shape) == handedness(body)
    np.testing.assert_allclose(shape.mean(0), 0, atol=1e-9)


def test_two_markers_have_a_trivial_shape():
    body, points = moving(1, markers=2)
    np.testing.assert_allclose(distances(mean_shape(points, distances(body))), distances(body), atol=1e-6)
