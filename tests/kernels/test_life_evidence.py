"""Evidence for a label at a point: highest at the predicted place, and blind to padding and batch mates."""

import numpy as np
import pytest

from dshpm_jax._control.tuning import TUNING
from dshpm_jax._kernels.life_evidence import life_evidence

NULL = TUNING.null_model
RNG = np.random.default_rng(3)
PLACES = RNG.uniform(-150, 150, (6, 3)).astype(np.float32)  # one rigid body of six markers


def table(size: int = 6, neighbours: int = 8):
    """Every marker is predicted by all others."""
    ids = np.full((size, neighbours), -1, np.int32)
    shape, own = np.zeros((size, neighbours, 3), np.float32), np.zeros((size, 3), np.float32)
    for m in range(6):
        others = [k for k in range(6) if k != m]
        ids[m, :5], shape[m, :5], own[m] = others, PLACES[others], PLACES[m]
    return ids, shape, own, np.full((size, neighbours), 3.0, np.float32), np.full(size, 4.0, np.float32)


def turned(points):
    angle = 0.7
    rotation = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return (points @ rotation.T + [300.0, -20.0, 50.0]).astype(np.float32)


def evidence(identified, points, tables=None):
    """Of every point for every marker of one frame; a lane for each marker."""
    ids, *rest = tables or table()
    places = np.where((ids >= 0)[..., None], identified[np.maximum(ids, 0)], np.float32(np.nan))
    lanes = [np.moveaxis(x, 0, -1) for x in (np.repeat(points[None], len(ids), 0), places, *rest)]
    return np.asarray(life_evidence(*lanes, null=NULL))


def test_each_marker_has_most_evidence_for_its_own_place():
    found = evidence(turned(PLACES), turned(PLACES))
    assert (found.argmax(1) == np.arange(6)).all()
    assert (np.diag(found) > 8.0).all()


def test_evidence_falls_with_distance():
    steps = np.array([0.0, 3.0, 10.0, 30.0, 100.0, 300.0], np.float32)
    points = turned(PLACES)[2] + steps[:, None] * np.array([0.0, 0.0, 1.0], np.float32)
    found = evidence(turned(PLACES), points)[:, 2]
    assert (np.diff(found) < 0).all()
    assert found[-1] < 0 < found[2]


def test_a_mirror_image_is_told_from_the_marker():
    here = turned(PLACES)
    known = here.copy()
    known[3:] = np.nan  # three neighbours of marker 5: their plane has two sides
    normal = np.cross(here[1] - here[0], here[2] - here[0])
    normal /= np.linalg.norm(normal)
    mirrored = here[5] - 2 * ((here[5] - here[0]) @ normal) * normal
    found = evidence(known, np.stack([here[5], mirrored.astype(np.float32)]))[:, 5]
    assert found[0] > found[1] + 3.0


def test_two_neighbours_leave_distances_and_one_nothing():
    here = turned(PLACES)
    known = np.full_like(here, np.nan)
    known[:2] = here[:2]
    assert 0 < evidence(known, here)[5, 5]
    known[1] = np.nan
    absent = np.full((1, 3), np.nan, np.float32)
    found = evidence(known, np.concatenate([here, absent]))
    assert (found[:6, 5] == NULL.unknown_llr).all() and (found[6] == NULL.min_llr).all()


def test_one_wrong_neighbour_does_not_spoil_a_prediction():
    here = turned(PLACES)
    known = here.copy()
    known[0] += 15.0  # 26 mm off, as after an exchange with a near marker
    found = evidence(known, here)
    assert (np.diag(found)[1:] > 2.0).all()


@pytest.mark.parametrize("extra", [1, 10])
def test_padding_and_lane_mates_change_nothing(extra):
    here = turned(PLACES)
    alone = evidence(here, here)
    known = np.concatenate([here, np.full((extra, 3), np.nan, np.float32)])
    points = np.concatenate([here, np.full((extra, 3), np.nan, np.float32)])
    padded = evidence(known, points, table(6 + extra))
    np.testing.assert_allclose(padded[:6, :6], alone, atol=2e-3)
    assert (padded[6:] == NULL.min_llr).all()
