"""SubjectModel from labelled recordings of planted figures."""

import numpy as np
import pytest

from dshpm_jax import Recording, SubjectModel
from dshpm_jax._model import pair_tolerance


def turns(angles: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Rotations about one axis (Rodrigues), one for each angle."""
    axis = axis / np.linalg.norm(axis)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angles)[:, None, None] * cross + (1 - np.cos(angles))[:, None, None] * (cross @ cross)


JOINTS = np.array([[0.0, 0, 0], [300, 0, 0], [600, 0, 0]])


def planted(rng: np.random.Generator) -> list[np.ndarray]:
    """Places of five markers on each body when the chain is stretched (mm), well away from the joints."""
    return [JOINTS[b] + rng.uniform([90, -80, -80], [210, 80, 80], (5, 3)) for b in range(3)]


def chain(frames: int = 200, seed: int = 0, noise: float = 0.5) -> tuple[np.ndarray, list[list[int]]]:
    """Three rigid bodies of five markers that swing about two ball joints; points (mm) and the markers of each."""
    rng = np.random.default_rng(seed)
    bodies = planted(rng)
    time = np.linspace(0, 4 * np.pi, frames)
    rotation = turns(0.3 * np.sin(time), np.array([0.0, 0, 1]))
    place = np.stack([500 * np.sin(time / 2), time * 20, np.full(frames, 900.0)], axis=-1)
    points = []
    for b, body in enumerate(bodies):
        points.append(np.einsum("fij,mj->fmi", rotation, body - JOINTS[b]) + place[:, None])
        place = place + rotation @ (JOINTS[min(b + 1, 2)] - JOINTS[b])
        bend = turns(1.0 * np.sin((b + 1.3) * time), np.array([0.0, 1, 0]))
        swing = turns(0.8 * np.cos((b + 0.7) * time), np.array([0.0, 0, 1]))
        rotation = rotation @ bend @ swing
    found = np.concatenate(points, axis=1)
    return found + rng.normal(scale=noise, size=found.shape), [list(range(5 * b, 5 * b + 5)) for b in range(3)]


def recording(points: np.ndarray, labels: list[str] | None = None) -> Recording:
    return Recording(points, tuple(labels or [f"q{i}" for i in range(points.shape[1])]), rate=100.0)


def test_planted_bodies_and_their_tree_are_found_again():
    points, bodies = chain()
    model = SubjectModel.from_recordings([recording(points)])
    assert sorted(segment.markers for segment in model.segments) == [tuple(b) for b in bodies]
    parents = {segment.markers[0] // 5: segment.parent for segment in model.segments}
    order = {s: segment.markers[0] // 5 for s, segment in enumerate(model.segments)}
    assert {frozenset((b, order[p])) for b, p in parents.items() if p >= 0} == {frozenset((0, 1)), frozenset((1, 2))}


def test_joint_centres_are_where_they_were_planted():
    points, _ = chain()
    for segment in (model := SubjectModel.from_recordings([recording(points)])).segments:
        if segment.parent < 0:
            continue
        assert segment.virtual_join is not None and segment.virtual_join.spread < 4
        # The first frame of a segment's own shape cannot be compared across frames, distances to markers can.
        child, parent = segment, model.segments[segment.parent]
        joint = max(child.markers[0], parent.markers[0]) // 5
        own = max(child, parent, key=lambda s: s.markers[0])
        place = segment.virtual_join.in_segment if own is child else segment.virtual_join.in_parent
        truth = planted(np.random.default_rng(0))[joint]
        expected = np.linalg.norm(truth - JOINTS[joint], axis=-1)
        np.testing.assert_allclose(np.linalg.norm(own.shape - place, axis=-1), expected, atol=6)


def test_the_order_of_columns_changes_nothing_but_the_order():
    points, _ = chain()
    order = np.random.default_rng(1).permutation(points.shape[1])
    one = SubjectModel.from_recordings([recording(points)])
    other = SubjectModel.from_recordings([recording(points[:, order], [f"q{i}" for i in order])])
    groups = [{frozenset(m.markers[i] for i in s.markers) for s in m.segments} for m in (one, other)]
    assert groups[0] == groups[1]
    np.testing.assert_allclose(other.pair_mean, one.pair_mean[np.ix_(order, order)])
    np.testing.assert_allclose(other.pair_spread, one.pair_spread[np.ix_(order, order)])


def test_unlabelled_columns_and_unseen_markers_are_left_out():
    points, _ = chain()
    extra = np.concatenate([points, points[:, :1] + 50, np.full_like(points[:, :1], np.nan)], axis=1)
    model = SubjectModel.from_recordings([recording(extra, [f"q{i}" for i in range(15)] + ["*12", "gone"])])
    assert model.markers == tuple(f"q{i}" for i in range(15))


def test_a_recording_without_labels_is_refused():
    points, _ = chain(20)
    with pytest.raises(ValueError, match="no labelled marker"):
        SubjectModel.from_recordings([recording(points, ["*1"] * 15)])
    with pytest.raises(ValueError, match="at least one"):
        SubjectModel.from_recordings([])


def test_too_little_motion_says_what_to_do():
    points, _ = chain()
    with pytest.raises(ValueError, match="too little motion.*segments in a file"):
        SubjectModel.from_recordings([recording(points[:1])])


def test_a_single_frame_takes_segments_from_a_mapping():
    points, bodies = chain()
    mapping = {f"body {b}": {"markers": [f"q{i}" for i in body]} for b, body in enumerate(bodies)}
    mapping["body 1"]["parent"] = mapping["body 2"]["parent"] = "body 0"
    model = SubjectModel.from_recordings([recording(points[:1])], segments=mapping)
    assert [segment.name for segment in model.segments] == list(mapping)
    assert [segment.parent for segment in model.segments] == [-1, 0, 0]
    assert all(0.05 <= segment.distortion_ratio <= 0.2 for segment in model.segments)
    assert (model.pair_spread[np.triu_indices(15, 1)] >= 2).all()  # nothing is rigid because one frame says so
    for segment, body in zip(model.segments, bodies):
        seen = np.linalg.norm(points[0, body] - points[0, body].mean(0), axis=-1)
        np.testing.assert_allclose(np.linalg.norm(segment.shape, axis=-1), seen)


@pytest.mark.parametrize(
    ("mapping", "message"),
    [
        ({"a": {"markers": ["q0", "nose"]}}, "nose"),
        ({"a": {"markers": ["q0", "q1"]}}, "no segment holds"),
        ({"a": {"markers": []}}, "needs a list"),
        ({}, "no segments"),
        ({"a": [f"q{i}" for i in range(15)], "b": {"markers": ["q0"], "parent": "c"}}, "unknown parent"),
        ({n: {"markers": [f"q{i}" for i in range(15)], "parent": p} for n, p in ("ab", "ba")}, "exactly one"),
    ],
)
def test_bad_segments_are_refused(mapping, message):
    points, _ = chain(20)
    with pytest.raises(ValueError, match=message):
        SubjectModel.from_recordings([recording(points)], segments=mapping)


def test_tolerances_grow_with_spread():
    points, _ = chain()
    model = SubjectModel.from_recordings([recording(points)])
    tolerance = pair_tolerance(model, spreads=1.5, floor=4.0, share=0.015)
    assert (tolerance >= 4).all()
    assert tolerance[0, 14] > tolerance[0, 1]


def test_large_segments_are_split_and_their_halves_share_a_pose():
    points = np.random.default_rng(0).normal(scale=200, size=(1, 40, 3))
    model = SubjectModel.from_recordings([recording(points)], segments={"body": [f"q{i}" for i in range(40)]})
    assert max(len(segment.markers) for segment in model.segments) <= 16
    assert {m for segment in model.segments for m in segment.markers} == set(range(40))
    assert all(len(segment.join) >= 3 for segment in model.segments if segment.parent >= 0)
    assert len({segment.name for segment in model.segments}) == len(model.segments)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_smallest_models(count):
    points, _ = chain(30)
    mapping = {"all": [f"q{i}" for i in range(count)]}
    model = SubjectModel.from_recordings([recording(points[:, :count])], segments=mapping)
    assert model.segments[0].shape.shape == (count, 3) and np.isfinite(model.segments[0].shape).all()


PLUG_IN_GAIT = "LASI RASI LPSI RPSI LTHI LKNE LTIB LANK LHEE LTOE RTHI RKNE RTIB RANK RHEE RTOE".split()


@pytest.mark.parametrize("template", [None, "plug-in-gait", "body-parts"])
def test_a_still_recording_takes_segments_from_names(template):
    points = np.random.default_rng(0).normal(scale=300, size=(1, 16, 3))
    model = SubjectModel.from_recordings([recording(points, PLUG_IN_GAIT)], template=template)
    found = {s.name: {model.markers[m] for m in s.markers} for s in model.segments}
    assert found["left shank"] == {"LKNE", "LTIB", "LANK"}
    assert len(found) == 7 and found["pelvis"] == {"LASI", "RASI", "LPSI", "RPSI"}


def test_an_unknown_template_is_refused():
    points, _ = chain(20)
    with pytest.raises(ValueError, match="no template 'nose'.*plug-in-gait"):
        SubjectModel.from_recordings([recording(points)], template="nose")
    with pytest.raises(ValueError, match="knows none of the markers"):
        SubjectModel.from_recordings([recording(points)], template="plug-in-gait")
