"""Gaps, ghosts, noise and lost names: as much as was asked for, and a truth that fits."""

from dataclasses import replace

import numpy as np
import pytest

from dshpm_jax._recording import Recording
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH
from dshpm_jax.synthesis import Truth, add_ghosts, distort, open_gaps, person, scramble


@pytest.fixture(scope="module")
def clean():
    return person(34, "walking", 400).recording


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.mark.parametrize("fraction", [0.0, 0.1, 0.5])
def test_gaps_take_what_was_asked(clean, rng, fraction):
    spoilt = open_gaps(clean, fraction, rng)
    assert 1 - spoilt.present.mean() == pytest.approx(fraction, abs=1e-4)
    np.testing.assert_array_equal(spoilt.points[spoilt.present], clean.points[spoilt.present])
    assert clean.present.all()


def test_gaps_fall_evenly_on_the_markers(clean, rng):
    lost = 1 - open_gaps(clean, 0.2, rng).present.mean(0)
    assert lost.min() > 0.05 and lost.max() < 0.4


def test_gaps_end_within_a_second(clean, rng):
    present = open_gaps(clean, 0.03, rng).present
    gone = [len(run) for column in present.T for run in "".join("01"[int(p)] for p in column).split("1") if run]
    assert 1 <= min(gone) and max(gone) <= 120  # two gaps may meet


def test_longer_pieces_are_fewer(clean, rng):
    pieces = {}
    for longest in (1.0, 4.0):
        worn = add_ghosts(open_gaps(clean, 0.1, rng, longest), 0.1, rng, longest_seconds=longest)
        assert 1 - worn.present[:, worn.labelled].mean() == pytest.approx(0.1, abs=1e-4)
        pieces[longest] = len(from_columns(worn.points, worn.rate))
    assert clean.points.shape[1] < pieces[4.0] < 0.6 * pieces[1.0]


@pytest.mark.parametrize("near", [False, True])
@pytest.mark.parametrize("fraction", [0.0, 0.1, 0.6])
def test_ghosts_are_as_many_as_asked(clean, rng, fraction, near):
    spoilt = add_ghosts(clean, fraction, rng, near)
    ghosts = spoilt.points[:, ~spoilt.labelled]
    assert np.isfinite(ghosts[..., 0]).sum() == pytest.approx(fraction * clean.present.sum(), abs=1)
    np.testing.assert_array_equal(spoilt.points[:, spoilt.labelled], clean.points)
    if fraction:
        low, high = clean.points.min((0, 1)), clean.points.max((0, 1))
        assert np.nanmin(ghosts - low) >= -1e-9 and np.nanmax(ghosts - high) <= 1e-9


def test_where_nothing_is_seen_there_is_no_place_for_ghosts(clean, rng):
    empty = replace(clean, points=np.full_like(clean.points, np.nan))
    assert add_ghosts(empty, 0.0, rng) is empty
    with pytest.raises(ValueError, match="no point is seen"):
        add_ghosts(empty, 0.1, rng)


def test_near_ghosts_of_an_empty_frame_are_in_the_box_of_the_take(clean, rng):
    points = clean.points.copy()
    points[1:] = np.nan
    ghosts = add_ghosts(replace(clean, points=points), 0.5, rng, near=True).points[:, clean.points.shape[1] :]
    assert np.isfinite(ghosts[1:]).any() and np.nanmin(ghosts - points[0].min(0)) >= -1e-9


def test_ghosts_go_straight(clean, rng):
    spoilt = add_ghosts(clean, 0.1, rng)
    bends = np.diff(spoilt.points[:, ~spoilt.labelled], n=2, axis=0)
    np.testing.assert_allclose(bends[np.isfinite(bends)], 0, atol=1e-8)


def test_distortion_has_the_spread_of_the_paper(clean, rng):
    """The change of a difference of two points has the root mean square of half the level times the length."""
    moved = distort(clean, 0.2, 300.0, rng).points - clean.points
    between = np.linalg.norm(moved[:, :17] - moved[:, 17:], axis=-1)
    assert np.sqrt((between**2).mean()) == pytest.approx(0.5 * 0.2 * 300, rel=0.02)


@pytest.mark.parametrize("trajectories", [True, False])
def test_truth_fits_the_points(clean, rng, trajectories):
    """Every point that the truth names is that marker's, every marker's point is named, the rest are ghosts."""
    spoilt = add_ghosts(open_gaps(clean, 0.15, rng), 0.15, rng)
    bare, truth = scramble(spoilt, rng, trajectories)
    assert not bare.labelled.any()
    assert truth.names == clean.labels
    assert bare.present.sum() == spoilt.present.sum()
    frame, column = np.nonzero(truth.identities != NO_MATCH)
    marker = truth.identities[frame, column]
    np.testing.assert_array_equal(bare.points[frame, column], clean.points[frame, marker])
    assert len(frame) == spoilt.present[:, spoilt.labelled].sum()
    assert len(set(zip(frame, marker, strict=True))) == len(frame)


def test_each_trajectory_has_a_column(clean, rng):
    spoilt = open_gaps(clean, 0.15, rng)
    bare, truth = scramble(spoilt, rng)
    assert bare.points.shape[1] == len(from_columns(spoilt.points, spoilt.rate))
    for column in truth.identities.T:
        lives = np.flatnonzero(column != NO_MATCH)
        assert len(set(column[lives])) == 1 and len(lives) == np.ptp(lives) + 1


def test_raw_points_stand_in_no_order(clean, rng):
    bare, truth = scramble(open_gaps(clean, 0.1, rng), rng, trajectories=False)
    assert bare.points.shape[1] <= 34
    seen = truth.identities[1:] != NO_MATCH
    assert (truth.identities[1:] == truth.identities[:-1])[seen].mean() < 0.1


def test_the_same_generator_spoils_the_same_way(clean):
    def spoil(seed):
        rng = np.random.default_rng(seed)
        return scramble(add_ghosts(open_gaps(clean, 0.1, rng), 0.1, rng), rng)[0].points

    np.testing.assert_array_equal(spoil(1), spoil(1))
    assert spoil(1).shape != spoil(2).shape or not np.array_equal(spoil(1), spoil(2), equal_nan=True)


def test_truth_in_the_numbers_of_a_model():
    truth = Truth(np.array([[0, 1, 2, NO_MATCH]]), ("a", "b", "c"))
    np.testing.assert_array_equal(truth.numbered_by(("c", "a")), [[1, NO_MATCH, 0, NO_MATCH]])


def test_short_recordings_are_spoilt_too(rng):
    short = Recording(np.zeros((3, 4, 3)), ("a", "b", "c", "d"), 60.0)
    assert open_gaps(short, 0.5, rng).present.sum() == 6
    assert add_ghosts(short, 0.5, rng).present.sum() == 18


@pytest.mark.parametrize("fraction", [-0.1, 1.0, np.nan])
def test_no_such_share_of_gaps(clean, rng, fraction):
    with pytest.raises(ValueError, match="share of the points"):
        open_gaps(clean, fraction, rng)
