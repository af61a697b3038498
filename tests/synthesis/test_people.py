"""Laws of synthetic figures: joints hold, soft tissue keeps its bounds, the same seed makes the same take."""

import numpy as np
import pytest

from dshpm_jax.synthesis import hand, person, robot_arm
from dshpm_jax.synthesis._machines import ROBOT_NOISE
from dshpm_jax.synthesis._people import NOISE, _subject

MAKERS = {
    **{
        f"{m} {a}": (lambda m=m, a=a, **k: person(m, a, **k))
        for m in (27, 30, 34, 49, 50)
        for a in ("walking", "freeform")
    },
    "34 running": lambda **k: person(34, "running", **k),
    "robot arm": robot_arm,
    "hand": hand,
}
MIN_APART = {"robot arm": 25.0, "hand": 12.0}  # mm; 25 mm for people too


@pytest.fixture(params=MAKERS, scope="module")
def made(request):
    return request.param, MAKERS[request.param](frames=300, seed=5)


def pair_distances(points):
    return np.linalg.norm(points[:, :, None] - points[:, None], axis=-1)


def columns(take, segment):
    return [take.recording.labels.index(name) for name in take.segments[segment]["markers"]]


def test_the_paper_s_protocols():
    for markers in (27, 30, 34, 49, 50):
        take = person(markers, frames=2)
        assert take.recording.points.shape == (2, markers, 3)
        assert len(take.segments) == 15
        assert all(len(s["markers"]) >= (2 if markers <= 30 else 3) for s in take.segments.values())
    assert len(robot_arm(frames=2).segments) == 7
    assert len(hand(frames=2).segments) == 16


def test_every_marker_has_a_name_and_a_segment(made):
    _, take = made
    names = take.recording.labels
    assert len(set(names)) == len(names)
    assert take.recording.labelled.all() and take.recording.present.all()
    assert {name for segment in take.segments.values() for name in segment["markers"]} == set(names)


def test_segments_form_one_tree(made):
    _, take = made
    parents = [segment["parent"] for segment in take.segments.values()]
    assert parents.count(None) == 1
    for k, parent in enumerate(parents):
        assert parent is None or list(take.segments).index(parent) < k


def test_joint_centres_coincide(made):
    """A segment's origin keeps its place in the frame of the parent: both have the same joint."""
    _, take = made
    order = list(take.segments)
    for s, segment in enumerate(take.segments.values()):
        if segment["parent"] is None:
            continue
        p = order.index(segment["parent"])
        arm = take.positions[:, s] - take.positions[:, p]
        joint = np.einsum("tji,tj->ti", take.rotations[:, p], arm)
        np.testing.assert_allclose(joint, joint[:1].repeat(len(joint), 0), atol=1e-6)


def test_poses_are_rotations(made):
    _, take = made
    unit = take.rotations @ np.swapaxes(take.rotations, -1, -2)
    np.testing.assert_allclose(unit, np.broadcast_to(np.eye(3), unit.shape), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(take.rotations), 1, atol=1e-9)


def test_links_of_a_robot_are_rigid():
    take = robot_arm(frames=300, seed=2)
    for segment in take.segments:
        found = pair_distances(take.recording.points[:, columns(take, segment)])
        assert np.ptp(found, axis=0).max() < 12 * ROBOT_NOISE


@pytest.mark.parametrize("activity", ["walking", "running", "freeform"])
def test_pair_distances_keep_within_the_soft_tissue(activity):
    """Of two markers of a segment: their softness, and for one over a joint half the way between both bones."""
    take, figure = person(49, activity, 300, seed=3), _subject(49, 0)
    order = list(take.segments)
    slack = np.zeros(49)
    for k, marker in enumerate(figure.markers):
        slack[k] = marker.softness
        if marker.shared:
            child, parent = (take.rotations[:, b] for b in (marker.bone, figure.bones[marker.bone].parent))
            bent = np.linalg.norm(child - parent, ord=2, axis=(1, 2)).max() / 2
            slack[k] += bent * (np.linalg.norm(marker.place) + marker.softness)
    for segment in order:
        held = columns(take, segment)
        spread = np.ptp(pair_distances(take.recording.points[:, held]), axis=0)
        bound = 2 * (slack[held][:, None] + slack[held]) + 16 * NOISE
        assert (spread <= bound).all()


def test_thighs_are_softer_than_the_head():
    take = person(34, "running", 600)
    spread = {
        name: pair_distances(take.recording.points[:, columns(take, name)]).std(0).max() for name in take.segments
    }
    assert spread["head"] < 1.5 < 3 < spread["left thigh"] < 20


def test_markers_keep_apart(made):
    name, take = made
    found = pair_distances(take.recording.points) + np.diag(np.full(take.recording.points.shape[1], np.inf))
    assert found.min() > MIN_APART.get(name, 25.0)


def test_every_joint_of_a_person_moves_within_seconds():
    take = person(34, "freeform", 600, seed=1)
    order = list(take.segments)
    for s, segment in enumerate(take.segments.values()):
        if segment["parent"] is not None:
            p = order.index(segment["parent"])
            relative = np.swapaxes(take.rotations[:, p], -1, -2) @ take.rotations[:, s]
            cosine = (np.trace(relative @ relative[0].T, axis1=1, axis2=2) - 1) / 2
            assert np.rad2deg(np.arccos(np.clip(cosine, -1, 1))).max() > 10


@pytest.mark.parametrize(("activity", "fastest"), [("walking", 8), ("running", 15), ("freeform", 12)])
def test_nothing_jumps(activity, fastest):
    """Metres a second, of the fastest marker; a foot swings at some three times the speed of the body."""
    take = person(34, activity, 900, rate=60.0, seed=4)
    speed = np.linalg.norm(np.diff(take.recording.points, axis=0), axis=-1) * 60 / 1000
    assert speed.max() < fastest
    assert take.recording.points[..., 2].min() > 0  # nobody sinks into the ground


def test_a_seed_makes_a_take(made):
    name, take = made
    again, other = MAKERS[name](frames=300, seed=5), MAKERS[name](frames=300, seed=6)
    np.testing.assert_array_equal(take.recording.points, again.recording.points)
    assert np.abs(take.recording.points - other.recording.points).max() > 50


def test_a_subject_has_a_body():
    """Takes of one subject share the lengths of the bones and the places of the markers; those of two do not."""

    def shank(take):
        s = list(take.segments).index("left foot")
        p = list(take.segments).index("left shank")
        return np.linalg.norm(take.positions[0, s] - take.positions[0, p])

    same = [shank(person(34, a, 2, subject=1, seed=k)) for k, a in enumerate(("walking", "running"))]
    assert same[0] == pytest.approx(same[1])
    assert abs(shank(person(34, frames=2, subject=2)) - same[0]) > 1


def test_the_rate_does_not_change_the_motion():
    slow, fast = person(34, frames=60, rate=60.0, seed=8), person(34, frames=120, rate=120.0, seed=8)
    apart = np.linalg.norm(slow.positions - fast.positions[::2], axis=-1)
    assert apart.max() < 60  # mm; sums of speeds differ a little with the step


def test_sides_are_alike_but_not_mirror_images():
    places = {m.name: np.array(m.place) for m in _subject(34, 0).markers}
    apart = [np.linalg.norm(places[name] - places["R" + name[1:]] * (1, -1, 1)) for name in places if name[0] == "L"]
    assert 0.5 < min(apart) and max(apart) < 25


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"markers": 31}, "one of .27, 30, 34, 49, 50."),
        ({"activity": "swimming"}, "standing, walking, running or freeform"),
        ({"frames": 0}, "one frame or more"),
    ],
)
def test_what_cannot_be_made(arguments, words):
    with pytest.raises(ValueError, match=words):
        person(**arguments)
