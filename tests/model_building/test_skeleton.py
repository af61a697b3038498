"""Models from skeletons: bones stay rigid, joints turn, and what nothing fixes is free."""

import numpy as np

from dshpm_jax import SubjectModel
from dshpm_jax._model_building.shapes import with_distances
from dshpm_jax._model_building.skeleton import Attached, Bone, Skeleton, posed_clip

BALL, HINGE = np.eye(3), np.eye(3)[:1]


def chain(turn: float = 0.3) -> Skeleton:
    """A trunk, a collar with a marker in front and one behind, and an upper arm, 200 mm each along x."""
    rng = np.random.default_rng(3)
    bones = (
        Bone("trunk", -1, np.zeros(3), np.eye(3), np.zeros((0, 3)), np.zeros(0)),
        Bone("collar", 0, np.array([200.0, 0, 0]), np.eye(3), BALL, np.full(3, turn)),
        Bone("arm", 1, np.array([200.0, 0, 0]), np.eye(3), BALL, np.full(3, turn)),
    )
    markers = [Attached(f"T{k}", 0, rng.normal(0, 100, 3), np.eye(3)) for k in range(5)]
    markers += [Attached(name, 1, np.array([150.0, 0, z]), np.eye(3)) for name, z in (("F", 80.0), ("B", -50.0))]
    markers += [Attached(f"A{k}", 2, np.array([100.0 * k, 20, 0]) + rng.normal(0, 30, 3), np.eye(3)) for k in range(4)]
    return Skeleton(bones, tuple(markers))


def spreads(skeleton: Skeleton) -> np.ndarray:
    clip = posed_clip(skeleton)
    return np.linalg.norm(clip[:, :, None] - clip[:, None], axis=-1).std(0)


def test_markers_of_a_bone_vary_by_their_covariance_alone():
    within = spreads(chain())[:5, :5][np.triu_indices(5, 1)]
    np.testing.assert_allclose(within, np.sqrt(2), rtol=0.2)


def test_markers_across_a_joint_vary_as_far_as_it_turns():
    assert spreads(chain(0.3))[0, 7:].min() > 2 * spreads(chain(0.05))[0, 7:].min()


def test_a_still_skeleton_is_its_default_pose():
    skeleton = chain(0.0)
    clip = posed_clip(skeleton)
    expected = np.array([m.place + [200.0 * m.bone, 0, 0] for m in skeleton.markers])
    fixed = [m for m, marker in enumerate(skeleton.markers) if marker.bone != 1]
    np.testing.assert_allclose(clip.mean(0)[fixed], expected[fixed], atol=0.3)


def test_a_bone_with_two_markers_turns_about_the_line_of_its_joints():
    """Front and back are as far from the trunk then, but not from the arm's joint, on which they turn."""
    clip = posed_clip(chain(0.0))
    front, back = clip[:, 5], clip[:, 6]
    assert front[:, 2].min() < -70 and front[:, 2].max() > 70
    np.testing.assert_allclose(np.hypot(front[:, 1], front[:, 2]).mean(), 80, atol=1)
    np.testing.assert_allclose(np.linalg.norm(front - back, axis=1).mean(), 130, atol=1)


def test_the_same_skeleton_gives_the_same_model():
    one, other = (SubjectModel.from_skeleton(chain(), "a.vsk") for _ in range(2))
    np.testing.assert_array_equal(one.pair_spread, other.pair_spread)
    assert one.sources == ("a.vsk",) and one.markers == tuple(m.name for m in chain().markers)


def test_segments_follow_the_bones():
    model = SubjectModel.from_skeleton(chain())
    groups = [{model.markers[m] for m in segment.markers} for segment in model.segments]
    assert {f"T{k}" for k in range(5)} in groups
    assert any({f"A{k}" for k in range(4)} <= group for group in groups)


def test_neighbourhoods_keep_their_distances():
    model = SubjectModel.from_skeleton(chain())
    near = model.neighbourhoods[5]
    assert near.markers[0] == 6
    assert abs(np.linalg.norm(near.shape[0] - near.shape[-1]) - 130) < 3


def test_shapes_with_given_distances():
    rng = np.random.default_rng(0)
    truth = rng.normal(0, 100, (6, 3))
    distances = np.linalg.norm(truth[:, None] - truth, axis=-1)
    found = with_distances(0.6 * truth, distances, np.ones((6, 6)))
    np.testing.assert_allclose(np.linalg.norm(found[:, None] - found, axis=-1), distances, atol=0.5)
    unknown = distances.copy()
    unknown[0, 1] = unknown[1, 0] = np.nan
    np.testing.assert_allclose(
        with_distances(truth, unknown, np.ones((6, 6))) @ np.ones(3), (truth - truth.mean(0)) @ np.ones(3), atol=0.5
    )
