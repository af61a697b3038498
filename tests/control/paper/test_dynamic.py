"""The dynamic scheme (section 4.3, Figs. 1 to 4): verify, recruit, shift, correct, abandon."""

from itertools import permutations

import chain
import numpy as np
import pytest
from chain import ARM, HAND, STICK, TRUNK
from fake_driver import FakeDriver
from test_segment import knowing

from dshpm_jax._control.paper.dynamic import (
    accept,
    assign_within,
    correct_parent,
    identify,
    identify_segment,
    key_frame,
    recruit_incomplete,
    verify,
)
from dshpm_jax._control.paper.propagation import propagate
from dshpm_jax._control.paper.segment import SegmentMatch
from dshpm_jax._control.partial_labels import PartialLabels
from dshpm_jax._requests import FitPoses, MatchSegment
from dshpm_jax._types import NO_MATCH

GHOST = np.array([600.0, 900.0, 200.0])  # where no marker comes near


def run(control):
    driver = FakeDriver()
    return driver.run(control), driver


def right_match(problem, segment, frame):
    """The true match of `segment`, as far as it is seen."""
    here = np.flatnonzero(problem.trajectories.alive(frame))
    by_marker = {int(m): int(j) for j, m in zip(here, chain.truth(problem)[here])}
    holder = np.array([by_marker.get(m, NO_MATCH) for m in chain.MEMBERS[segment]])
    return SegmentMatch(segment, frame, holder, 0.1)


def labels(problem, known):
    """Wrong labels, and how many trajectories have one."""
    named = known.identity != NO_MATCH
    return np.flatnonzero(named & (known.identity != chain.truth(problem))).tolist(), int(named.sum())


def test_the_key_frame_is_the_first_full_enough_one():
    points = chain.motion(20)
    points[:7, :2] = np.nan
    points[7:9, 0] = np.nan
    assert key_frame(chain.problem(points)) == 7  # 11 of 12 are more than 90 %
    points[:, 4:] = np.nan
    assert key_frame(chain.problem(points)) == 9


def test_everything_is_identified_in_a_clean_recording():
    problem = chain.problem(chain.motion(40))
    known, driver = run(identify(problem, 0))
    assert labels(problem, known) == ([], 12) and known.found.all() and driver.fits > 0


def test_ghosts_are_not_labelled():
    ghosts = np.random.default_rng(0).uniform(-200, 900, (1, 8, 3)) + np.zeros((40, 1, 1))
    problem = chain.problem(np.concatenate([chain.motion(40), ghosts], axis=1))
    known, _ = run(identify(problem, 0))
    assert labels(problem, known) == ([], 12)


def test_a_child_whose_parent_is_lost_is_matched_without_it():
    points = chain.motion(40)
    points[:, [5, 6]] = np.nan  # the arm keeps its joins only
    problem = chain.problem(points)
    known, driver = run(identify(problem, 0))
    assert known.found.tolist() == [True, False, True, True]
    assert labels(problem, known) == ([], 10)
    asked = [request.target.segment for request in driver.requests(MatchSegment)]
    assert asked.index(ARM) < asked.index(HAND)


def test_a_match_that_its_motion_contradicts_is_refused():
    points = chain.motion(40)
    problem = chain.problem(points)
    match = right_match(problem, TRUNK, 0)
    assert run(verify(problem, PartialLabels.nothing(problem), match))[0] is match
    points[:, 3] += np.linspace(0, 1, 40)[:, None] * [400, 0, 0]  # what was taken for marker 3 goes its own way
    problem = chain.problem(points)
    found, driver = run(verify(problem, PartialLabels.nothing(problem), right_match(problem, TRUNK, 0)))
    assert found is None and driver.fits == 1


@pytest.mark.parametrize(("method", "gone", "verified"), [("paper", 5, True), ("paper", 1, False), ("full", 5, False)])
def test_a_match_that_is_hidden_soon_is_verified_by_what_it_still_shows(method, gone, verified):
    points = chain.motion(40)
    points[gone:, :3] = np.nan
    problem = chain.problem(points, method=method)
    match = right_match(problem, TRUNK, 0)
    found, driver = run(verify(problem, PartialLabels.nothing(problem), match))
    assert (found is match) is verified and bool(driver.requests(FitPoses)) is verified


def test_a_match_that_falls_apart_before_it_is_hidden_is_refused():
    points = chain.motion(40)
    points[:, 3] += np.linspace(0, 4, 40)[:, None] * [400, 0, 0]
    points[12:, :2] = np.nan  # two markers remain at the end of the interval
    problem = chain.problem(points)
    assert run(verify(problem, PartialLabels.nothing(problem), right_match(problem, TRUNK, 0)))[0] is None


def test_going_back_a_match_is_verified_where_three_markers_are_still_seen():
    points = chain.motion(40)
    points[:30, :3] = np.nan
    problem = chain.problem(points)
    match = right_match(problem, TRUNK, 39)
    assert problem.later(39) < 30
    assert run(verify(problem, PartialLabels.nothing(problem), match))[0] is match


def test_the_static_method_and_small_segments_are_not_verified():
    points = chain.motion(40)
    points[5:] = np.nan
    for problem, segment in ((chain.problem(points, method="static"), TRUNK), (chain.problem(points), STICK)):
        match = right_match(problem, segment, 0)
        verified, driver = run(verify(problem, PartialLabels.nothing(problem), match))
        assert verified is match and not driver.asked


def test_verification_prefers_the_later_frame_if_it_shows_more():
    points = chain.motion(40)
    points[:10, 3] = np.nan
    problem = chain.problem(points)
    match = right_match(problem, TRUNK, 0)
    found, _ = run(verify(problem, PartialLabels.nothing(problem), match))
    assert match.size == 4 and found.size == 5
    assert found.frame == problem.relaxation and found.trajectories[3] == chain.trajectory_of(problem, 15, 3)


def test_lost_markers_are_recruited_where_they_are_predicted():
    points = np.concatenate([chain.motion(40), np.tile(GHOST, (40, 1, 1))], axis=1)
    points[:20, [1, 6]] = np.nan
    problem = chain.problem(points)
    known = knowing(problem, TRUNK, ARM)
    known.identity[[chain.trajectory_of(problem, 30, k) for k in (1, 6)]] = NO_MATCH
    _, driver = run(recruit_incomplete(problem, known, 30))
    assert labels(problem, known) == ([], 8) and len(driver.requests(FitPoses)) == 2
    assert known.recruited.sum() == 2  # the others were matched and stay so


def test_a_claimed_or_distant_point_is_not_recruited():
    points = chain.motion(40)
    points[:, 1] = chain.motion(40)[:, 1] + [0, 0, 60]  # too far from its place
    problem = chain.problem(points)
    known = knowing(problem, TRUNK)
    known.identity[chain.trajectory_of(problem, 0, 1)] = NO_MATCH
    run(recruit_incomplete(problem, known, 0))
    assert known.identity[chain.trajectory_of(problem, 0, 1)] == NO_MATCH


def test_a_segment_hidden_in_the_key_frame_is_found_after_a_shift():
    points = chain.motion(60)
    points[:10, 8:10] = np.nan
    problem = chain.problem(points)
    known = knowing(problem, TRUNK, ARM)
    found, driver = run(identify_segment(problem, known, HAND, 0))
    assert found and labels(problem, known) == ([], 11)
    assert len([r for r in driver.requests(MatchSegment) if r.target.segment == HAND]) == 2


def test_a_segment_that_is_not_there_is_abandoned():
    points = chain.motion(60)
    points[:, 8:] = np.nan
    problem = chain.problem(points)
    known = knowing(problem, TRUNK, ARM)
    before = known.identity.copy()
    found, driver = run(identify_segment(problem, known, HAND, 0))
    assert not found and not known.found[HAND]
    np.testing.assert_array_equal(known.identity, before)
    asked = [r for r in driver.requests(MatchSegment) if r.target.segment == HAND]
    assert len(asked) <= 1 + problem.settings.max_key_frame_shifts + 1


@pytest.mark.parametrize("hidden", [False, True])
def test_a_wrong_join_of_the_parent_is_corrected(hidden):
    """The trunk took a ghost for the shoulder; the arm cannot hang from there."""
    points = np.concatenate([chain.motion(60), chain.motion(60)[:, 4:5] + [90, -60, 70]], axis=1)
    problem = chain.problem(points)
    known = knowing(problem, TRUNK)
    ghost, shoulder = (chain.trajectory_of(problem, 0, k) for k in (12, 4))
    known.identity[ghost], known.identity[shoulder] = 4, NO_MATCH
    if hidden:  # the arm cannot be found either: everything stays as it was
        problem = chain.problem(np.where(np.isin(np.arange(13), [5, 6])[None, :, None], np.nan, points))
        known = knowing(problem, TRUNK)
        ghost, shoulder = (chain.trajectory_of(problem, 0, k) for k in (12, 4))
        known.identity[ghost], known.identity[shoulder] = 4, NO_MATCH
    before = known.identity.copy()
    corrected, _ = run(correct_parent(problem, known, ARM, 0))
    if hidden:
        assert not corrected
        np.testing.assert_array_equal(known.identity, before)
    else:
        assert corrected and labels(problem, known) == ([], 8)


def test_two_markers_need_a_neighbour_that_is_identified():
    points = chain.motion(40)
    points[:, 7:10] = np.nan  # no wrist, no hand: the stick hangs from nothing
    problem = chain.problem(points)
    known, _ = run(identify(problem, 0))
    assert not known.found[STICK] and not np.isin(known.identity, [10, 11]).any()


def test_accepting_takes_markers_and_trajectories_from_others():
    problem = chain.problem(chain.motion(20))
    known = PartialLabels.nothing(problem)
    match = right_match(problem, ARM, 0)
    known.identity[chain.trajectory_of(problem, 0, 0)] = 5
    known.identity[match.trajectories[0]] = 1
    accept(problem, known, match)
    assert labels(problem, known) == ([], 4) and known.found[ARM]


def test_what_reappears_is_recruited_both_ways():
    points = chain.motion(60)
    points[40:45, 1] = np.nan
    points[10:14, 9] = np.nan
    problem = chain.problem(points)
    known, _ = run(identify(problem, 20))
    assert known.identity[[chain.trajectory_of(problem, 59, 1), chain.trajectory_of(problem, 0, 9)]].tolist() == [
        -1,
        -1,
    ]
    run(propagate(problem, known, 20))
    assert labels(problem, known) == ([], 14)


@pytest.mark.parametrize("seed", range(20))
def test_nearest_pairs_are_one_to_one(seed):
    """As many as there can be; among those the least total distance, by trying them all."""
    rng = np.random.default_rng(seed)
    distance, reach = rng.uniform(0, 10, (3, 4)), rng.uniform(2, 8, 3)
    pairs = assign_within(distance, reach)
    assert len({r for r, _ in pairs}) == len({c for _, c in pairs}) == len(pairs)
    assert all(distance[r, c] <= reach[r] for r, c in pairs)
    best = min(
        (-len(kept), sum(distance[r, c] for r, c in kept))
        for way in permutations(range(4), 3)
        for kept in [[(r, c) for r, c in enumerate(way) if distance[r, c] <= reach[r]]]
    )
    assert (-len(pairs), sum(distance[r, c] for r, c in pairs)) == pytest.approx(best)
