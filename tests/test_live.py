"""Labels while the capture runs: the same as afterwards, whatever the blocks, and not later than promised."""

from dataclasses import replace

import numpy as np
import pytest
from takes import model, take

from dshpm_jax import Labeller, Settings, label

RATE = 60.0
DELAY = 1.0


@pytest.fixture(scope="module")
def recording():
    return take(0, frames=150, gaps=0.0, ghosts=0.05)[0]


def pushed(recording, size):
    """All identities, and how many frames were out after each block."""
    labeller = Labeller(model(), RATE, DELAY)
    parts, out = [], []
    for first in range(0, recording.num_frames, size):
        parts.append(labeller.push(recording.points[first : first + size]))
        out.append(sum(map(len, parts)))
    parts.append(labeller.finish())
    assert [part.first for part in parts] == [0, *out]
    return np.concatenate([part.identities for part in parts]), out


def test_labels_are_those_of_the_whole_recording(recording):
    live, _ = pushed(recording, 10)
    offline = label(recording, model()).identities
    assert live.shape == offline.shape
    assert (live == offline)[recording.present].mean() > 0.99
    both = (live != -1) & (offline != -1)
    assert (live == offline)[both].all()


def test_labels_come_in_time_and_whatever_the_blocks(recording):
    live, out = pushed(recording, 7)
    for k, frames in enumerate(out):
        assert min(7 * (k + 1), recording.num_frames) - frames < DELAY * RATE
    other, _ = pushed(recording, 150)
    np.testing.assert_array_equal(live, other)


def test_blocks_may_have_more_columns_than_those_before(recording):
    labeller = Labeller(model(), RATE, DELAY)
    first = labeller.push(recording.points[:40, :30])
    second = labeller.push(recording.points[40:80])
    last = labeller.finish()
    assert len(first) + len(second) + len(last) == 80
    assert last.identities.shape[1] == recording.points.shape[1]
    assert np.isfinite(last.markers).all(-1).any(0).sum() > 25


def test_empty_frames_are_handed_through():
    labeller = Labeller(model(), RATE, DELAY)
    assert len(labeller.push(np.full((60, 3, 3), np.nan))) > 0
    assert (labeller.finish().identities == -1).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((60.0, 0.1), "longer"),
        ((60.0, 2.0, Settings(method="paper")), "full"),
        ((60.0, 2.0, Settings(rescale=True)), "own model"),
    ],
)
def test_wrong_orders_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        Labeller(model(), *arguments)


def test_points_of_another_shape_are_refused():
    with pytest.raises(ValueError, match="shape"):
        Labeller(model(), RATE).push(np.zeros((3, 2)))


def test_a_model_that_cannot_judge_is_refused():
    with pytest.raises(ValueError, match="no neighbourhoods"):
        Labeller(replace(model(), neighbourhoods=()), RATE)
