"""What is asked of the matcher for one segment, and what is made of its answer (section 4.2)."""

from dataclasses import replace

import chain
import numpy as np
import pytest
from chain import ARM, HAND, TRUNK
from fake_driver import FakeDriver

from dshpm_jax._control.paper.segment import match_segment
from dshpm_jax._control.partial_labels import PartialLabels
from dshpm_jax._model import VirtualJoin
from dshpm_jax._requests import MatchSegment, SegmentMatches
from dshpm_jax._types import NO_MATCH


@pytest.fixture
def problem():
    return chain.problem(chain.motion(20))


def run(control, answers=None):
    driver = FakeDriver(answers)
    return driver.run(control), driver


def knowing(problem, *segments):
    """What is known when these segments have been identified rightly."""
    known = PartialLabels.nothing(problem)
    right = chain.truth(problem)
    for segment in segments:
        known.identity[np.isin(right, chain.MEMBERS[segment])] = right[np.isin(right, chain.MEMBERS[segment])]
        known.found[segment] = True
    return known


def scripted(*rows):
    """Answers any match with these rows of (assigned, error, accepted)."""
    assigned, error, accepted = (np.array(x) for x in zip(*rows))
    fits = np.arange(1, len(rows) + 1)
    return {MatchSegment: lambda _: SegmentMatches(assigned, (assigned >= 0).sum(1), error, accepted, fits)}


def test_without_a_join_every_marker_is_the_pivot_at_every_point(problem):
    match, driver = run(match_segment(problem, PartialLabels.nothing(problem), TRUNK, 0))
    asked = driver.requests(MatchSegment)[0]
    assert (asked.pinned == NO_MATCH).all() and asked.free.all()
    assert len(set(zip(asked.pivot, asked.assumed))) == 5 * 12
    assert chain.truth(problem)[match.trajectories].tolist() == [0, 1, 2, 3, 4]


def test_a_known_join_is_the_only_pivot(problem):
    match, driver = run(match_segment(problem, knowing(problem, TRUNK), ARM, 0))
    asked = driver.requests(MatchSegment)[0]
    assert asked.pivot.tolist() == [0] and asked.assumed.tolist() == [asked.pinned[0]]
    assert asked.free.sum() == 12 - 5 and not asked.free[asked.pinned[0]]
    assert chain.truth(problem)[match.trajectories].tolist() == [4, 5, 6, 7]


def test_giving_up_the_join_tries_all_pivots_again(problem):
    known = knowing(problem, TRUNK)
    match, driver = run(match_segment(problem, known, ARM, 0, use_joins=False))
    asked = driver.requests(MatchSegment)[0]
    assert (asked.pinned == NO_MATCH).all() and asked.free.sum() == 12 - 4  # what the segment itself has is free again
    assert chain.truth(problem)[match.trajectories].tolist() == [4, 5, 6, 7]


def test_first_acceptable_or_best():
    rows = scripted(([0, 1, 2, 3], 0.2, False), ([4, 5, 6, NO_MATCH], 0.9, True), ([4, 5, 6, 7], 0.3, True))
    for method, error, fits in (("paper", 0.9, 1 + 2), ("full", 0.3, 1 + 2 + 3)):
        problem = replace(chain.problem(chain.motion(20)))
        problem.settings = replace(problem.settings, method=method)
        known = PartialLabels.nothing(problem)
        match, driver = run(match_segment(problem, known, ARM, 0), rows)
        assert match.error == error and driver.fits == fits


def test_nothing_accepted_is_no_match(problem):
    known = PartialLabels.nothing(problem)
    match, driver = run(
        match_segment(problem, known, ARM, 0), scripted(([0, 1, 2, 3], 0.2, False), ([4, 5, 6, 7], 2.0, False))
    )
    assert match is None and driver.fits == 3


def test_a_banned_pair_is_passed_over(problem):
    at = int(np.flatnonzero(chain.truth(problem) == 0)[0])
    rows = scripted(([at, 5, 6, 7], 0.2, True), ([4, 5, 6, 7], 0.3, True))
    match, driver = run(
        match_segment(problem, PartialLabels.nothing(problem), ARM, 0, banned=frozenset({(4, at)})), rows
    )
    assert match.error == 0.3 and driver.fits == 1 + 2  # the paper fits what it then bans


def test_one_point_is_not_enough_to_ask():
    points = chain.motion(20)
    points[:, 1:] = np.nan
    problem = chain.problem(points)
    match, driver = run(match_segment(problem, PartialLabels.nothing(problem), TRUNK, 0))
    assert match is None and not driver.asked


def test_a_virtual_join_stands_in_for_one_that_is_not_there():
    problem = chain.problem(chain.motion(20))
    shoulder = chain.REST[4]
    centres = [chain.REST[list(chain.MEMBERS[s])].mean(0) for s in (TRUNK, ARM)]
    join = VirtualJoin(shoulder - centres[0], shoulder - centres[1], 2.0)
    segments = list(problem.model.segments)
    segments[ARM] = replace(segments[ARM], virtual_join=join, markers=(5, 6, 7), shape=segments[ARM].shape[1:], join=())
    problem = type(problem)(problem.trajectories, replace(problem.model, segments=tuple(segments)), problem.settings)
    match, driver = run(match_segment(problem, knowing(problem, TRUNK), ARM, 0))
    asked = driver.requests(MatchSegment)[0]
    assert len(asked.points) == 13 and asked.pinned.tolist() == [NO_MATCH] * 3 + [12]
    assert asked.pivot.tolist() == [3] and not asked.free[12] and asked.rigid[12].all()
    _, points = problem.trajectories.at(0)
    assert np.linalg.norm(asked.points[12] - points[chain.trajectory_of(problem, 0, 4)]) < 2
    assert chain.truth(problem)[match.trajectories].tolist() == [5, 6, 7]


def test_a_virtual_join_needs_a_pose_of_the_parent():
    problem = chain.problem(chain.motion(20))
    segments = list(problem.model.segments)
    segments[HAND] = replace(segments[HAND], virtual_join=VirtualJoin(np.zeros(3), np.zeros(3), 2.0))
    problem = type(problem)(problem.trajectories, replace(problem.model, segments=tuple(segments)), problem.settings)
    _, driver = run(match_segment(problem, PartialLabels.nothing(problem), HAND, 0))
    assert len(driver.requests(MatchSegment)[0].points) == 12
