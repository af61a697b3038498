"""Raw points linked to tracks, and columns cut where they jump."""

import jax
import numpy as np
import pytest
import reference
from equinox.debug import assert_max_traces
from scipy.optimize import linear_sum_assignment

from dshpm_jax._columns import columns_are_tracks, unbroken_columns
from dshpm_jax._kernels import tracking
from dshpm_jax._kernels.tracking import NUM_ROUNDS, RIVAL_MARGIN, RIVAL_RATIO, track
from dshpm_jax._pretracking import pretrack
from dshpm_jax._recording import Recording
from dshpm_jax._types import NO_MATCH

RATE = 100.0
link = jax.jit(tracking._unrivalled)


def motion(frames=150, points=20, speed=2000.0, seed=0):
    """Points on smooth paths, millimetres: together across the room, each swinging by itself."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None, None] / RATE
    swing = rng.normal(0, 60, (points, 3)) * np.sin(2 * np.pi * t * rng.uniform(0.5, 2, (points, 3)))
    return rng.uniform(0, 1500, (points, 3)) + swing + t * np.array([speed, 0, 0])


def with_gaps(points, share=0.01, seed=0):
    rng = np.random.default_rng(seed)
    points = points.copy()
    for t, i in np.argwhere(rng.random(points.shape[:2]) < share):
        points[t : t + rng.integers(1, 15), i] = np.nan
    return points


def shuffled(points, seed=0, width=None):
    """The points of each frame in random columns, and whose they are."""
    rng = np.random.default_rng(seed)
    width = width or points.shape[1]
    mixed = np.full((len(points), width, 3), np.nan)
    identity = np.full(mixed.shape[:2], NO_MATCH)
    for t, frame in enumerate(points):
        seen = np.flatnonzero(np.isfinite(frame).all(-1))
        columns = rng.permutation(width)[: len(seen)]
        mixed[t, columns], identity[t, columns] = frame[seen], seen
    return mixed, identity


def count_links(links, identity):
    """How many links join one point's positions, how many two points', and how many there could be."""
    t, i = np.nonzero(links != NO_MATCH)
    assert (identity[t, i] != NO_MATCH).all()
    same = identity[t, i] == identity[t + 1, links[t, i]]
    possible = sum(len(np.intersect1d(a[a >= 0], b[b >= 0])) for a, b in zip(identity, identity[1:]))
    for row in links:
        assert len(set(row[row >= 0])) == (row >= 0).sum()
    return int(same.sum()), int((~same).sum()), possible


@pytest.mark.parametrize("speed", [0.0, 2000.0, 8000.0])
def test_shuffled_points_are_tracked(speed):
    points, identity = shuffled(with_gaps(motion(speed=speed)))
    right, wrong, possible = count_links(track(points, RATE), identity)
    assert wrong == 0
    assert right > 0.97 * possible


def test_a_gap_ends_a_track():
    points = motion(points=3, speed=0.0)
    points[50:53, 1] = np.nan
    links = track(points, RATE)
    assert links[49, 1] == NO_MATCH and (links[50:53, 1] == NO_MATCH).all()
    assert links[48, 1] == 1 and links[53, 1] == 1
    assert (links[-1] == NO_MATCH).all()


def test_the_order_of_columns_does_not_matter():
    points = with_gaps(motion())
    order = np.random.default_rng(1).permutation(points.shape[1])
    plain, mixed = track(points, RATE), track(points[:, order], RATE)
    back = np.where(mixed == NO_MATCH, NO_MATCH, order[mixed])
    np.testing.assert_array_equal(back, plain[:, order])


def test_neither_the_place_nor_a_point_far_away_matters():
    points = with_gaps(motion())
    plain = track(points, RATE)
    astray = np.random.default_rng(2).uniform(1e7, 2e7, (len(points), 1, 3))
    np.testing.assert_array_equal(track(points + (2e5, -1e5, 3e4), RATE), plain)
    np.testing.assert_array_equal(track(np.concatenate([points, astray], axis=1), RATE)[:, :-1], plain)


def test_two_that_meet_are_cut_rather_than_confused():
    t = np.linspace(-1, 1, 101)
    crossing = np.zeros((101, 2, 3))
    crossing[:, 0, 0], crossing[:, 1, 0] = 300 * np.abs(t), -300 * np.abs(t)  # meet and part again: none can tell
    links = track(crossing, RATE)
    _, wrong, _ = count_links(links, np.tile([0, 1], (101, 1)))
    assert wrong == 0
    assert (links[50] == NO_MATCH).any()


def test_blinking_points_are_no_track():
    points = np.full((40, 2, 3), np.nan)
    points[::2, 0], points[1::2, 1] = [0, 0, 0], [60, 0, 0]
    points[::4] = np.nan
    assert (track(points, RATE) == NO_MATCH).all()


def test_little_or_nothing_to_track():
    assert track(np.zeros((0, 4, 3)), RATE).shape == (0, 4)
    assert (track(np.full((7, 4, 3), np.nan), RATE) == NO_MATCH).all()
    np.testing.assert_array_equal(track(motion(frames=2, points=5), RATE)[0], np.arange(5))
    assert (track(motion(frames=1, points=5), RATE) == NO_MATCH).all()


def one_step(seed):
    """Predictions, the points they are to be linked to, how far each may miss, which points are there; distances."""
    rng = np.random.default_rng(seed)
    predicted = rng.uniform(0, 300, (12, 3)).astype(np.float32)
    frame = (predicted[rng.permutation(12)] + rng.normal(0, 8, (12, 3))).astype(np.float32)
    reach, seen = np.full(12, 120, np.float32), rng.random(12) > 0.1
    reach[rng.random(12) < 0.1] = -1
    distance = np.linalg.norm(predicted[:, None].astype(np.float64) - frame, axis=-1)
    distance[(distance > reach[:, None]) | ~seen[None]] = np.inf
    return (predicted, frame, reach, seen), distance


@pytest.mark.parametrize("seed", range(20))
def test_links_by_loops(seed):
    step, distance = one_step(seed)
    expected = reference.unrivalled_links(distance, RIVAL_RATIO, RIVAL_MARGIN, NUM_ROUNDS)
    np.testing.assert_array_equal(link(*step), expected)


def test_links_are_nearly_always_the_optimal_ones():
    """Where points are missing, the optimum moves rivals about that we leave unlinked or accept as they are."""
    agree = total = 0
    for seed in range(100):
        step, distance = one_step(seed)
        found = np.asarray(link(*step))
        rows, columns = linear_sum_assignment(np.minimum(distance, 60))  # to leave both ends free costs that much
        linked = found[rows] != NO_MATCH
        agree, total = agree + (found[rows][linked] == columns[linked]).sum(), total + linked.sum()
    assert total > 700
    assert agree >= 0.98 * total


def test_few_programs_for_many_sizes(monkeypatch):
    step = assert_max_traces(tracking._advance, max_traces=2)  # one for each of two widths
    monkeypatch.setattr(tracking, "_advance", step)
    monkeypatch.setattr(tracking, "track_chunk", jax.jit(tracking.track_chunk.__wrapped__))
    for frames, points in ((10, 4), (200, 30), (40, 32), (20, 33), (300, 60)):
        track(motion(frames, points), RATE)


def test_columns_are_told_from_shuffled_points():
    for speed in (0.0, 8000.0):
        points = with_gaps(motion(speed=speed))
        assert columns_are_tracks(points)
        assert not columns_are_tracks(shuffled(points)[0])
        assert not columns_are_tracks(shuffled(points, width=60)[0])


def test_still_and_short_columns_are_believed():
    assert columns_are_tracks(np.broadcast_to(np.arange(12.0).reshape(1, 4, 3), (30, 4, 3)))
    points = np.full((60, 30, 3), np.nan)
    path = motion(60, 1)[:, 0]
    for k in range(30):  # two frames each
        points[2 * k : 2 * k + 2, k] = path[2 * k : 2 * k + 2]
    assert columns_are_tracks(points)
    assert columns_are_tracks(np.zeros((0, 3, 3)))


def test_columns_are_cut_where_they_swap_and_jump():
    points = motion(points=6, speed=1000.0)
    points[60:, [1, 2]] = points[60:, [2, 1]]
    points[90:, 4] += 900
    cut = np.argwhere(unbroken_columns(points, RATE)[:-1] == NO_MATCH)
    swap, jump = {(59, 1), (59, 2)}, {(89, 4)}
    after = {(60, 1), (60, 2), (90, 4)}
    assert swap | jump <= set(map(tuple, cut)) <= swap | jump | after


def test_columns_in_order_are_left_alone():
    points = with_gaps(motion(speed=5000.0))
    present = np.isfinite(points).all(-1)
    whole = unbroken_columns(points, RATE)[:-1] != NO_MATCH
    np.testing.assert_array_equal(whole, present[:-1] & present[1:])


@pytest.mark.parametrize("mixed", [False, True])
def test_every_point_is_in_one_trajectory(mixed):
    points = with_gaps(motion())
    points = shuffled(points)[0] if mixed else points
    found = pretrack(Recording(points, ("",) * points.shape[1], RATE))
    frame, slot = np.nonzero(found.index != NO_MATCH)
    places = set(zip(frame, found.column[frame, slot]))
    assert len(places) == len(frame) == np.isfinite(points).all(-1).sum()
    np.testing.assert_array_equal(found.points[frame, slot], points[frame, found.column[frame, slot]])


def test_real_recording(data):
    """A sprint at 9 m/s: shuffled, no wrong link and hardly one missed."""
    lines = (data / "sprinter-51" / "run0900cms.trc").read_text().splitlines()[5:]
    points = np.array([line.split("\t")[2 : 2 + 51 * 3] for line in lines if line.strip()], float).reshape(-1, 51, 3)
    mixed, identity = shuffled(points)
    assert not columns_are_tracks(mixed) and columns_are_tracks(points)
    right, wrong, possible = count_links(track(mixed, 250.0), identity)
    assert wrong == 0
    assert right > 0.985 * possible
