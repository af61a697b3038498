"""The full method's own parts: moves mend what single assignments cannot, doubtful labels are withheld."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from takes import model, shares, take

from dshpm_jax import Reason, Recording, Settings, SubjectModel, label_many
from dshpm_jax._control import voting
from dshpm_jax._control.assignment import any_overlap
from dshpm_jax._control.decision import FITTED_BADLY, alternatives, ceiling_of, decide
from dshpm_jax._control.evidence import fewer_frames, frame_evidence, labels_in, posture, sample_frames
from dshpm_jax._control.full import full
from dshpm_jax._control.resolving import poor_frames, resolve
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State, improve, model_fit, settle
from dshpm_jax._driver import Driver
from dshpm_jax._labelling import POOR_FIT
from dshpm_jax._pretracking import pretrack
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH

DRIVER = Driver()
HEAD = ("LFHD", "RFHD", "LBHD", "RBHD")


@pytest.fixture(scope="module")
def scene_and_truth():
    recording, truth = take(0)
    tracks = pretrack(recording)
    right = truth.numbered_by(model().markers)
    column = tracks.column[tracks.start, tracks.slot]
    return Scene(tracks, model(), Settings()), right[tracks.start, column]


def run(control):
    return next(DRIVER.run([control]))


@pytest.mark.parametrize(("seconds", "wanted"), [(1, 10), (200, 10), (201, 11), (3600, 180)])
def test_long_recordings_have_more_key_frames(seconds, wanted):
    tracks = from_columns(np.zeros((seconds * 2, 1, 3)), 2.0)
    assert voting.usual_number(Scene(tracks, model(), Settings())) == wanted


def test_every_trajectory_is_sampled(scene_and_truth):
    scene, _ = scene_and_truth
    frames = sample_frames(scene)
    seen = np.unique(scene.trajectories.index[frames])
    assert set(range(len(scene.trajectories))) <= set(seen.tolist())


@pytest.mark.parametrize("step", [1, 3, 1000])
def test_every_trajectory_is_in_some_of_fewer_frames(scene_and_truth, step):
    scene, _ = scene_and_truth
    frames = sample_frames(scene)
    few = fewer_frames(scene, frames, step)
    assert set(few.tolist()) <= set(frames.tolist()) and (np.diff(few) > 0).all()
    assert len(few) == len(frames) if step == 1 else len(few) < len(frames)
    assert set(np.unique(scene.trajectories.index[few])) == set(np.unique(scene.trajectories.index[frames]))


@pytest.mark.parametrize("pair", [("LWRA", "LWRB"), ("RFHD", "LBHD"), ("LTOE", "LHEE")])
def test_exchanged_labels_are_mended(scene_and_truth, pair):
    scene, truth = scene_and_truth
    a, b = (model().markers.index(name) for name in pair)
    swapped = np.where(truth == a, b, np.where(truth == b, a, truth))
    frames = sample_frames(scene)

    def control():
        state = yield from settle(scene, swapped, frames)
        return (yield from improve(scene, state, frames))

    found = run(control()).identity
    touched = np.isin(truth, [a, b])
    assert (found[touched] == truth[touched]).all()


def test_truth_is_worth_more_than_a_turned_head(scene_and_truth):
    scene, truth = scene_and_truth
    turned = with_turned_head(truth)
    frames = sample_frames(scene)
    right, wrong = (run(settle_as(scene, labels, frames)) for labels in (truth, turned))
    assert (turned != truth).any() and right.worth > 1.05 * wrong.worth


def with_turned_head(truth):
    """The labels of the head turned by half about the vertical."""
    front_left, front_right, back_left, back_right = (model().markers.index(name) for name in HEAD)
    to = np.append(np.arange(model().num_markers), NO_MATCH)  # NO_MATCH is -1 and takes the last
    to[[front_left, back_right, front_right, back_left]] = back_right, front_left, back_left, front_right
    return to[truth]


def test_what_is_given_out_is_right_and_the_rest_has_a_reason(scene_and_truth):
    scene, truth = scene_and_truth
    state, fits = run(full(scene))
    identity, confidence, reason = decide(scene, state)
    given = identity != NO_MATCH
    assert fits > 0 and (identity[given] == truth[given]).all()
    assert ((0 <= confidence) & (confidence <= 1)).all()
    assert all((r is Reason.MATCHED) == g for r, g in zip(reason, given))


def test_another_body_fits_worse_whatever_is_missing(scene_and_truth):
    scene, truth = scene_and_truth
    frames = sample_frames(scene)
    other = Scene(scene.trajectories, scene.model.scaled(1.2), scene.settings)
    fewer = np.where(np.arange(len(truth)) % 4 == 0, NO_MATCH, truth)
    own, lacking, odd, empty = (
        model_fit(where, run(settle_as(where, labels, frames)))
        for where, labels in ((scene, truth), (scene, fewer), (other, truth), (scene, np.full(len(truth), NO_MATCH)))
    )
    assert own > 1.1 * POOR_FIT and lacking > POOR_FIT and odd < POOR_FIT and empty == 0.0


def settle_as(scene, labels, frames):
    """The state of just these labels."""
    found = yield from frame_evidence(scene, frames, labels_in(scene, labels, frames))
    return State.of(scene, labels, frames, found)


def test_no_label_of_a_doubtful_model_is_certain(scene_and_truth):
    scene, truth = scene_and_truth
    assert ceiling_of(POOR_FIT) == 1.0 and scene.settings.min_confidence < FITTED_BADLY
    state = run(settle(scene, truth, sample_frames(scene)))
    identity, confidence, _ = decide(scene, state)
    same, less, _ = decide(scene, state, ceiling_of(0.99 * POOR_FIT))
    np.testing.assert_array_equal(same, identity)
    named = identity != NO_MATCH
    np.testing.assert_array_equal(less[named], np.minimum(confidence[named], FITTED_BADLY))
    np.testing.assert_array_equal(less[~named], confidence[~named])


@pytest.mark.parametrize(("least", "none_left"), [(0.0, False), (1.0, True)])
def test_labels_under_the_least_confidence_are_withheld(scene_and_truth, least, none_left):
    scene, truth = scene_and_truth
    strict = Scene(scene.trajectories, scene.model, Settings(min_confidence=least))
    state = run(settle(strict, truth, sample_frames(strict)))
    identity, _, reason = decide(strict, state)
    named = state.identity != NO_MATCH
    assert (identity[named] == NO_MATCH).all() == none_left
    withheld = named & (identity == NO_MATCH)
    assert {reason[j] for j in np.flatnonzero(withheld)} <= {Reason.AMBIGUOUS, Reason.DOUBTFUL}
    assert withheld.any() == none_left
    assert (alternatives(state, identity)[withheld, 0] == state.identity[withheld]).all()


def test_what_else_a_trajectory_could_be():
    evidence = np.array([[9.0, 8.0, 1.0], [9.0, 1.0, 1.5], [3.0, 9.0, 4.0], [1.0, 5.0, 6.0]])
    state = State(np.array([0, 0, 1, NO_MATCH]), evidence, 0.0, None)  # type: ignore[arg-type]
    given_out = np.array([0, 0, NO_MATCH, NO_MATCH])
    none = NO_MATCH
    assert alternatives(state, given_out).tolist() == [[1, none], [none, none], [1, 2], [2, none]]


def test_a_distance_that_fits_nothing_says_nothing(scene_and_truth):
    scene, _ = scene_and_truth
    places = np.full((2, scene.model.num_markers, 3), np.nan)
    places[:, :6] = np.random.default_rng(5).uniform(0, 400, (6, 3))
    places[1, 2] = 1e5
    without = places[:1].copy()
    without[0, 2] = np.nan
    assert posture(scene, places)[1] == pytest.approx(posture(scene, without)[0], abs=1e-3)


def test_a_model_may_know_no_distance_at_all(scene_and_truth):
    scene, truth = scene_and_truth
    blind = replace(scene.model, pair_mean=np.full_like(scene.model.pair_mean, np.nan))
    places = np.random.default_rng(6).normal(0, 400, (3, blind.num_markers, 3))
    assert (posture(Scene(scene.trajectories, blind, Settings()), places) == 0).all()


def test_posture_is_that_of_each_frame_alone(scene_and_truth, monkeypatch):
    scene, _ = scene_and_truth
    places = np.random.default_rng(6).normal(0, 400, (20, scene.model.num_markers, 3))
    places[np.random.default_rng(7).random(places.shape[:2]) < 0.3] = np.nan
    together = posture(scene, places)
    monkeypatch.setattr("dshpm_jax._control.evidence.FRAMES_AT_ONCE", 7)
    np.testing.assert_array_equal(posture(scene, places), together)
    assert posture(scene, places[:0]).shape == (0,)


def test_divided_votes_lead_to_more_starts(scene_and_truth, monkeypatch):
    scene, truth = scene_and_truth
    state, fits = run(full(scene))
    monkeypatch.setattr(voting, "DIVIDED", 1.1)
    best, more_fits = run(full(scene))
    assert more_fits > 3 * fits and best.worth >= state.worth
    kept = best.identity != NO_MATCH
    assert (best.identity[kept] == truth[kept]).mean() > 0.99 and kept.mean() > 0.95 * (
        state.identity != NO_MATCH
    ).mean()


def test_a_label_that_other_starts_do_not_lead_to_is_taken_back(scene_and_truth, monkeypatch):
    scene, truth = scene_and_truth
    frames = sample_frames(scene)
    states = [run(settle(scene, truth, frames))] * 4
    odd = np.flatnonzero(states[0].identity != NO_MATCH)[0]
    for k in (1, 2):
        other = states[k].identity.copy()
        other[odd] = NO_MATCH
        states[k] = replace(states[k], identity=other)
    queue = iter(states)

    def led_by(scene, votes, scale, frames):
        votes.count[0, :2] = 1  # divided: two votes, and no label
        yield from ()
        return next(queue)

    monkeypatch.setattr("dshpm_jax._control.full._led_by", led_by)
    found, _ = run(full(scene))
    assert found.identity[odd] == NO_MATCH
    np.testing.assert_array_equal(np.delete(found.identity, odd), np.delete(states[0].identity, odd))


def test_a_segment_without_labels_is_poor_and_labelled_again(scene_and_truth):
    scene, truth = scene_and_truth
    frames = sample_frames(scene)
    segment = next(s for s, target in enumerate(scene.targets) if len(target.markers) >= 4)
    own = np.isin(truth, scene.targets[segment].markers)
    bare = np.where(own, NO_MATCH, truth)

    def control():
        known = yield from settle(scene, truth, frames)
        found = yield from frame_evidence(scene, frames, labels_in(scene, bare, frames))
        left = State(bare, known.evidence, -np.inf, found)
        poor = poor_frames(scene, left, frames)
        return poor, (yield from resolve(scene, left, frames))

    poor, state = run(control())
    assert segment in poor and set(poor[segment]) <= set(frames.tolist())
    assert (state.identity[own] == truth[own]).mean() > 0.9


def test_what_is_missing_is_poor_even_where_most_of_the_body_is(scene_and_truth):
    scene, truth = scene_and_truth
    frames, sizes = sample_frames(scene), [len(target.markers) for target in scene.targets]
    kept = scene.targets[int(np.argmax(sizes))].markers
    bare = np.where(np.isin(truth, kept), truth, NO_MATCH)
    state = State.of(scene, bare, frames, run(frame_evidence(scene, frames, labels_in(scene, bare, frames))))
    assert len(poor_frames(scene, state, frames)) > len(sizes) / 2


def test_half_of_the_points_are_enough():
    recording, right = take(1, frames=300, gaps=0.5, ghosts=0.0)
    (labelling,) = label_many([recording], [model()])
    labelled, wrong = shares(labelling.identities, recording, right)
    assert labelled > 0.95 and wrong < 0.02


def test_a_segment_whose_markers_are_merely_hidden_is_not_looked_for(scene_and_truth):
    scene, truth = scene_and_truth
    segment = next(s for s, target in enumerate(scene.targets) if len(target.markers) >= 4)
    hidden = np.isin(truth, scene.targets[segment].markers[2:]) | (truth == NO_MATCH)  # and no false point is there
    tracks = scene.trajectories
    gone = np.isin(tracks.index, np.flatnonzero(hidden))
    points, index = np.where(gone[..., None], np.nan, tracks.points), np.where(gone, NO_MATCH, tracks.index)
    bare = Scene(replace(tracks, points=points, index=index), model(), Settings())
    frames = sample_frames(scene)
    state = run(settle(bare, np.where(hidden, NO_MATCH, truth), frames))
    assert segment not in poor_frames(bare, state, frames)


def test_no_label_stays_on_two_points_of_a_frame(scene_and_truth):
    """Even where labels to start from say so, as exchanges for a while may: both would count, and so win."""
    scene, truth = scene_and_truth
    t, twice = scene.trajectories, np.array(truth)
    longest = np.argsort(t.start - t.stop, kind="stable")
    first, second = longest[np.isin(truth[longest], scene.targets[0].markers)][:2]
    twice[second] = truth[first]
    assert any_overlap(twice, t.start, t.stop) and not any_overlap(truth, t.start, t.stop)
    state = run(settle(scene, twice, sample_frames(scene)))
    assert not any_overlap(state.identity, t.start, t.stop) and np.isfinite(state.worth)


def test_a_rigid_triangle_fits_its_own_model():
    """No marker has three neighbours, so what a right label usually holds is that of distances."""
    corners = np.array([[0.0, 0, 0], [150, 0, 0], [0, 240, 0]])
    takes = [tumbling(corners, seed) for seed in (1, 2)]
    wand = SubjectModel.from_recordings(takes[:1], {"wand": list("ABC")})
    (labelling,) = label_many([replace(takes[1], labels=("*1", "*2", "*3"))], [wand], Settings(min_confidence=0.95))
    assert (labelling.identity[np.argsort(labelling.trajectories.slot)] == [0, 1, 2]).all()
    assert labelling.stats["model_fit"] > POOR_FIT


def tumbling(corners: np.ndarray, seed: int) -> Recording:
    rng, time = np.random.default_rng(seed), np.arange(120) / 60
    turned = Rotation.from_rotvec(np.stack([np.sin(time * k + rng.uniform(0, 6)) for k in (1.1, 0.7, 0.5)], 1))
    points = np.einsum("fij,mj->fmi", turned.as_matrix(), corners) + 300 * np.sin(time)[:, None, None] + 1000
    return Recording(points + rng.normal(0, 0.3, points.shape), tuple("ABC"), 60.0)


def test_what_resolving_found_may_turn_the_rest(scene_and_truth, monkeypatch):
    """A leg that is found again can show that the other one carries its labels."""

    def stage(step):
        def control(scene, state, frames):
            yield from ()
            return SimpleNamespace(worth=step.get(state.worth, state.worth))

        return control

    improve, turned, resolve = stage({}), stage({2: 3}), stage({1: 2})
    parts = {
        "improve": improve,
        "turn": turned,
        "STAGES": (improve, turned, resolve, improve),
        "_started": lambda *_: stage({})(None, SimpleNamespace(worth=1), None),
        "_share_held": lambda *_: 1.0,
        "Votes": SimpleNamespace(none=lambda _: SimpleNamespace(divided=False, fits=0)),
    }
    for name, part in parts.items():
        monkeypatch.setattr(f"dshpm_jax._control.full.{name}", part)
    state, _ = run(full(scene_and_truth[0]))
    assert state.worth == 3
