"""Labels that are given: what they forbid, where they cut, and what is left of a move."""

import numpy as np
from chain import RATE, model, problem

from dshpm_jax import Settings
from dshpm_jax._control.fixed_labels import CLOSED_LLR, FixedLabels, fix
from dshpm_jax._control.full.assignment import assign
from dshpm_jax._control.full.moves import Move, around_fixed
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._trajectories import Trajectories, from_columns
from dshpm_jax._types import NO_MATCH, UNKNOWN


def tracks() -> Trajectories:
    """Four columns of ten frames: two seen throughout, one in the first half, one in the second."""
    points = np.zeros((10, 4, 3)) + np.arange(4)[:, None] * 100.0
    points[5:, 2] = points[:5, 3] = np.nan
    return from_columns(points, RATE)


def given(*identity: int) -> FixedLabels:
    return FixedLabels.of(tracks(), np.array(identity, np.int32), 12)


def test_a_label_is_closed_to_all_that_share_a_frame_with_its_trajectory():
    fixed = given(UNKNOWN, UNKNOWN, 5, UNKNOWN)
    assert fixed.open is not None
    assert fixed.open[:, 5].tolist() == [False, False, True, True] and fixed.open[:2, :5].all()
    assert fixed.open[2].sum() == 1


def test_who_is_no_marker_can_be_none():
    fixed = given(NO_MATCH, UNKNOWN, UNKNOWN, UNKNOWN)
    assert fixed.open is not None and not fixed.open[0].any() and fixed.open[1:].all()
    assert (fixed.llr(np.zeros((4, 12)))[0] == CLOSED_LLR).all()


def test_labels_make_room():
    fixed = given(7, NO_MATCH, UNKNOWN, UNKNOWN)
    assert fixed.on(np.array([1, 2, 7, 3])).tolist() == [7, NO_MATCH, NO_MATCH, 3]
    assert FixedLabels.none(tracks()).on(np.array([1, 2, 7, 3])).tolist() == [1, 2, 7, 3]


def test_an_assignment_goes_around_them():
    problem = LabellingProblem(tracks(), model(), Settings(), fixed=given(UNKNOWN, UNKNOWN, 5, UNKNOWN))
    gain = np.zeros((4, 12))
    gain[:, 5], gain[0, 1], gain[2] = 9.0, 1.0, -1.0
    assert assign(problem, gain).tolist() == [1, NO_MATCH, 5, 5]


def test_what_is_left_of_a_move():
    problem = LabellingProblem(tracks(), model(), Settings(), fixed=given(UNKNOWN, 4, UNKNOWN, UNKNOWN))
    move = around_fixed(problem, Move(np.array([0, 1, 2]), np.array([4, 3, 6]), 1.0))
    assert move.trajectories.tolist() == [0, 2] and move.labels.tolist() == [NO_MATCH, 6]


def test_trajectories_are_cut_where_what_is_known_changes():
    points = np.full((10, 4), UNKNOWN)
    points[3:6, 0], points[:, 1], points[:3, 2] = 5, NO_MATCH, 6
    t, known, whole = fix(tracks(), points)
    rows = sorted(zip(t.column[t.start, t.slot].tolist(), t.start.tolist(), t.stop.tolist(), known.tolist()))
    column_0 = [(0, 0, 3, UNKNOWN), (0, 3, 6, 5), (0, 6, 10, UNKNOWN)]
    assert rows == [*column_0, (1, 0, 10, NO_MATCH), (2, 0, 3, 6), (2, 3, 5, UNKNOWN), (3, 5, 10, UNKNOWN)]
    assert np.bincount(whole).tolist() == [3, 1, 2, 1]


def test_they_go_with_the_trajectories():
    before = LabellingProblem(tracks(), model(), Settings(), fixed=given(UNKNOWN, 4, UNKNOWN, UNKNOWN))
    t, source = before.trajectories.cut(np.array([1]), np.array([5]))
    after = before.of(t, source)
    assert (after.fixed.identity == np.where(source == 1, 4, UNKNOWN)).all()
    assert before.loosened(2.0).fixed is before.fixed


def test_a_part_of_the_frames_is_a_recording_of_its_own():
    whole = tracks()
    part, which = whole.between(5, 8)
    assert which.tolist() == [0, 1, 3] and part.num_frames == 3
    assert part.start.tolist() == [0, 0, 0] and part.stop.tolist() == [3, 3, 3]
    for new, old in enumerate(which.tolist()):
        np.testing.assert_array_equal(
            part.positions(np.arange(3), np.array([new])), whole.positions(np.arange(5, 8), np.array([old]))
        )
    assert (part.index[:, part.slot] == np.arange(3)).all()


def test_by_default_nothing_is_given():
    assert not problem(np.zeros((3, 12, 3))).fixed.given.any()
