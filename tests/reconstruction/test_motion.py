"""Poses, joins and filled gaps of a planted figure, whose truth is known."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from dshpm_jax import Found, Motion, Recording, SubjectModel, reconstruct, write_motion
from dshpm_jax.synthesis import Synthetic, open_gaps, robot_arm

RIGID = 1.0  # mm: the arm is rigid, and measured to a tenth of a millimetre


@cache
def arm(seed: int = 0, frames: int = 240) -> Synthetic:
    return robot_arm(frames=frames, seed=seed)


@cache
def model() -> SubjectModel:
    return SubjectModel.from_recordings([arm(1, 400).recording], segments=arm().segments)


def without(recording: Recording, *gaps: tuple[str, slice]) -> Recording:
    points = recording.points.copy()
    for label, frames in gaps:
        points[frames, recording.labels.index(label)] = np.nan
    return replace(recording, points=points)


def places(motion: Motion, segment: int) -> np.ndarray:
    shape = motion.model.segments[segment].shape
    return np.einsum("fij,mj->fmi", motion.rotations[:, segment], shape) + motion.translations[:, segment, None]


def errors(motion: Motion, truth: Recording) -> np.ndarray:
    """How far each segment's markers are from where they truly are (frames, segments; mm)."""
    found = []
    for s, segment in enumerate(motion.model.segments):
        columns = [truth.labels.index(motion.model.markers[m]) for m in segment.markers]
        found.append(np.linalg.norm(places(motion, s) - truth.points[:, columns], axis=-1).max(1))
    return np.stack(found, axis=1)


def test_all_markers_give_all_poses():
    motion = reconstruct(arm().recording, model())
    assert (motion.found == Found.MEASURED).all()
    assert errors(motion, arm().recording).max() < 3 * RIGID and np.nanmax(motion.residual) < RIGID
    np.testing.assert_allclose(np.linalg.det(motion.rotations), 1.0, atol=1e-9)


def test_turns_are_those_of_the_truth():
    motion, truth = reconstruct(arm().recording, model()), arm().rotations
    for s in range(truth.shape[1]):
        constant = np.einsum("fji,fjk->fik", truth[:, s], motion.rotations[:, s])
        turned = np.swapaxes(constant[:1], -1, -2) @ constant
        angle = np.degrees(np.arccos(np.clip((np.trace(turned, axis1=-2, axis2=-1) - 1) / 2, -1, 1)))
        assert angle.max() < 1.5


def test_one_wrong_point_among_many_does_not_move_a_pose():
    truth = arm().recording
    big = max(model().segments, key=lambda s: len(s.markers))
    assert len(big.markers) >= 4
    wrong = truth.points.copy()
    wrong[50:60, truth.labels.index(model().markers[big.markers[0]])] += 150.0
    motion = reconstruct(replace(truth, points=wrong), model())
    assert errors(motion, truth)[:, model().segments.index(big)].max() < 4 * RIGID


def short_of_points() -> tuple[Motion, int, slice]:
    """The arm with one of its middle links down to a single marker of its own for a while."""
    segments = model().segments
    s = next(s for s, one in enumerate(segments) if one.parent != -1 and any(o.parent == s for o in segments))
    gap = slice(100, 130)
    gone = [(model().markers[m], gap) for m in segments[s].markers[1:]]
    return reconstruct(without(arm().recording, *gone), model()), s, gap


def test_a_segment_with_one_marker_is_held_by_its_joints():
    motion, s, gap = short_of_points()
    assert (motion.found[gap, s] == Found.ARTICULATED).all()
    assert (np.delete(motion.found, np.r_[gap], axis=0) == Found.MEASURED).all()
    middle = np.median(errors(motion, arm().recording)[gap, s])
    assert middle < 25.0, middle  # of a link some hundred millimetres long


def test_what_is_not_seen_at_all_is_interpolated_for_a_while_only():
    last = len(model().segments) - 1
    names = [model().markers[m] for m in model().segments[last].markers]
    rate = int(arm().recording.rate)
    short, long = slice(60, 60 + rate // 4), slice(60, 60 + 2 * rate)
    for gap, how in ((short, Found.INTERPOLATED), (long, Found.NONE)):
        motion = reconstruct(without(arm().recording, *((name, gap) for name in names)), model())
        assert (motion.found[gap, last] == how).all()
        assert np.isfinite(motion.translations[gap, last]).all() == (how != Found.NONE)


def test_joins_lie_where_both_segments_have_them():
    motion = reconstruct(arm().recording, model())
    for s, segment in enumerate(model().segments):
        if segment.parent == -1:
            assert np.isnan(motion.joins[:, s]).all()
        elif segment.virtual_join is not None:
            inside = np.einsum("fji,fj->fi", motion.rotations[:, s], motion.joins[:, s] - motion.translations[:, s])
            np.testing.assert_allclose(inside.std(0), 0.0, atol=3 * RIGID)


def test_filled_gaps_end_where_the_points_are_and_move_nothing_measured():
    truth = arm().recording
    worn = open_gaps(truth, 0.2, np.random.default_rng(0))
    filled = reconstruct(worn, model()).filled()
    assert filled.mask.sum() > 0.95 * (~worn.present).sum() and not (filled.mask & worn.present).any()
    np.testing.assert_array_equal(filled.recording.points[worn.present], worn.points[worn.present])
    np.testing.assert_array_equal(filled.recording.present, filled.mask | worn.present)
    apart = np.linalg.norm(filled.recording.points - truth.points, axis=-1)
    assert np.median(apart[filled.mask]) < 2 * RIGID
    edge = filled.mask[1:] & worn.present[:-1]
    step = np.linalg.norm(np.diff(filled.recording.points, axis=0), axis=-1)[edge]
    true_step = np.linalg.norm(np.diff(truth.points, axis=0), axis=-1)[edge]
    assert np.median(np.abs(step - true_step)) < RIGID


def test_longer_gaps_can_stay_open_and_markers_never_seen_do():
    truth = arm().recording
    one, other = truth.labels[0], truth.labels[1]
    motion = reconstruct(without(truth, (one, slice(20, 25)), (one, slice(100, 200)), (other, slice(None))), model())
    mask = motion.filled(max_seconds=0.2).mask
    assert mask[20:25, 0].all() and mask.sum() == 5
    assert motion.filled().mask[100:200, 0].all() and not motion.filled().mask[:, 1].any()


def test_a_labelling_says_the_same_as_its_recording():
    from making import make_labelling

    truth = arm().recording
    motion = reconstruct(make_labelling(truth, model().markers))
    assert (motion.found != Found.NONE).any() and motion.recording.labels[: model().num_markers] == model().markers


def test_wrong_calls_are_named():
    from making import make_labelling

    recording = arm().recording
    with pytest.raises(ValueError, match="needs the model"):
        reconstruct(recording)
    with pytest.raises(ValueError, match="its own model"):
        reconstruct(make_labelling(recording, model().markers), model())
    with pytest.raises(ValueError, match="none of its labels"):
        reconstruct(replace(recording, labels=tuple(f"x{k}y" for k in range(len(recording.labels)))), model())


def test_the_file_says_what_the_motion_says(tmp_path):
    motion = reconstruct(without(arm().recording, (arm().recording.labels[0], slice(20, 25))), model())
    write_motion(motion, tmp_path / "arm.npz", motion.filled())
    with np.load(tmp_path / "arm.npz") as found:
        np.testing.assert_array_equal(found["rotations"], motion.rotations)
        np.testing.assert_array_equal(found["found"], motion.found)
        np.testing.assert_array_equal(found["filled"], motion.filled().mask)
        assert found["labels"].tolist() == list(motion.recording.labels)
        assert found["segments"].tolist() == [s.name for s in model().segments] and found["rate"] == 60.0
