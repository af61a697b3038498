"""Chains that carry each other's labels: which are counterparts, and that their exchange is undone."""

import numpy as np
import pytest
from takes import model, take

from dshpm_jax import Settings
from dshpm_jax._control.evidence import frame_evidence, labels_in, sample_frames
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State, settle
from dshpm_jax._control.turning import turn
from dshpm_jax._driver import Driver
from dshpm_jax._pretracking import pretrack


@pytest.fixture(scope="module")
def scene_and_truth():
    recording, truth = take(0)
    tracks = pretrack(recording)
    column = tracks.column[tracks.start, tracks.slot]
    return Scene(tracks, model(), Settings()), truth.numbered_by(model().markers)[tracks.start, column]


def changes(to: np.ndarray) -> dict[str, str]:
    """By name, what a turn makes of the labels that it changes."""
    names = model().markers
    return {names[a]: names[b] for a, b in enumerate(to) if a != b}


def other_side(name: str) -> str:
    return {"L": "R", "R": "L"}[name[0]] + name[1:]


def test_limbs_are_counterparts_of_those_across(scene_and_truth):
    scene, _ = scene_and_truth
    of_one_kind = [names for names in map(changes, scene.body.turns) if all(n[0] in "LR" for n in names)]
    assert any({"LELB", "LWRA"} <= names.keys() for names in of_one_kind)
    assert any({"LKNE", "LANK"} <= names.keys() for names in of_one_kind)
    swaps = [names for names in of_one_kind if names == {name: other_side(name) for name in names}]
    assert any("LELB" in names for names in swaps) and any("LKNE" in names for names in swaps)


def test_a_turn_gives_every_label_once(scene_and_truth):
    scene, _ = scene_and_truth
    for to in scene.body.turns:
        assert sorted(to) == list(range(model().num_markers))


def test_every_turn_is_undone(scene_and_truth):
    scene, truth = scene_and_truth
    frames, driver = sample_frames(scene), Driver()
    for to in scene.body.turns:
        turned = np.where(truth >= 0, to[truth], truth)
        state = next(driver.run([settle(scene, turned, frames)]))
        found = next(driver.run([turn(scene, state, frames)]))
        assert found.worth >= state.worth
        touched = (truth >= 0) & (turned != truth)
        assert (found.identity[touched] == truth[touched]).mean() > 0.95, changes(to)


def test_legs_exchanged_for_a_while_are_exchanged_back():
    recording, right = take(3, frames=600, gaps=0.4)
    tracks = pretrack(recording)
    scene = Scene(tracks, model(), Settings())
    truth = right.numbered_by(model().markers)[tracks.start, tracks.column[tracks.start, tracks.slot]]
    legs = next(to for to in scene.body.turns if {"LKNE", "LANK"} <= changes(to).keys() <= set(model().markers))
    inside = (truth >= 0) & (tracks.start >= 150) & (tracks.stop <= 450)
    exchanged = np.where(inside, legs[truth], truth)
    assert (exchanged != truth).sum() > 5
    frames, driver = sample_frames(scene), Driver()
    evidence = next(driver.run([frame_evidence(scene, frames, labels_in(scene, exchanged, frames))]))
    state = State.of(scene, exchanged, frames, evidence)
    found = next(driver.run([turn(scene, state, frames)]))
    assert (found.identity[exchanged != truth] == truth[exchanged != truth]).mean() > 0.95
