"""Spikes begin and end with a leap, and are short."""

import numpy as np
import pytest

from dshpm_jax._control.uses.spikes import leaps, spikes

RATE, FRAMES = 100.0, 200


@pytest.fixture
def points() -> np.ndarray:
    """Two markers that run in circles, a metre a second and more."""
    angle = np.linspace(0, 6 * np.pi, FRAMES)
    circle = 150 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    return np.stack([circle, circle + 90.0], axis=1)


def evidence(fall: float, frames: slice) -> np.ndarray:
    own = np.full((FRAMES, 2), 11.0)
    own[frames, 0] -= fall
    return own


def test_leaps_are_off_the_course(points):
    assert leaps(points)[1:].max() < 2.0
    points[80, 0] += 40.0
    assert (leaps(points)[:, 0] > 30.0).nonzero()[0].tolist() == [79, 80, 81]
    points[80, 0] = np.nan
    assert leaps(points)[79:81, 0].tolist() == [0.0, 0.0]


@pytest.mark.parametrize(("first", "last"), [(80, 80), (80, 82), (50, 68)])
def test_a_point_that_leaps_off(points, first, last):
    points[first : last + 1, 0] += 40.0
    assert spikes(evidence(9.0, slice(first, last + 1)), points, RATE) == [(0, first, last, 9.0)]


@pytest.mark.parametrize("change", ["smooth", "small", "mild", "long", "one-sided", "at the end"])
def test_what_is_no_spike(points, change):
    first, last = {"long": (50, 90), "at the end": (195, 199)}.get(change, (80, 82))
    if change == "one-sided":
        points[first:, 0] += 40.0
    elif change != "smooth":
        points[first : last + 1, 0] += 8.0 if change == "small" else 40.0
    fall = 4.0 if change == "mild" else 9.0
    assert spikes(evidence(fall, slice(first, last + 1)), points, RATE) == []


def test_the_wider_of_two_runs(points):
    points[80:84, 0] += 40.0
    own = evidence(7.0, slice(80, 84))
    own[82, 0] = 0.0
    assert [spike[:3] for spike in spikes(own, points, RATE)] == [(0, 80, 83)]


def test_nothing_to_judge(points):
    assert spikes(np.full((FRAMES, 2), np.nan), points, RATE) == []
