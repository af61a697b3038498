"""A piece of a recording whose beginning is labelled: the labels go on, and what is new or lost is looked for."""

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.assignment import assign_labels
from dshpm_jax._control.decision import ceiling_of, decide
from dshpm_jax._control.evidence import sample_frames
from dshpm_jax._control.full import full
from dshpm_jax._control.resolving import resolve
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State, improve, model_fit, settle
from dshpm_jax._labelling import Reason
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH

LOST = 0.5
"""All is looked for anew when the labels carried on are worth less than this share of what right ones usually are."""


def follow(scene: Scene, given: Int[np.ndarray, "frames columns"]) -> Control:
    """Labels for the trajectories of `scene`, as `decide` has them.

    Arguments:
        given: labels that points of the recording have already, `NO_MATCH` for the others.
    """
    start = carried_on(scene, given)
    if (start == NO_MATCH).all():
        state, _ = yield from full(scene)
        return _decided(scene, state)
    frames = sample_frames(scene)
    state = yield from settle(scene, start, frames)
    state = yield from improve(scene, state, frames)
    state = yield from resolve(scene, state, frames)
    if _share(scene, state) < LOST:
        anew, _ = yield from full(scene)
        state = max(state, anew, key=lambda s: s.worth)
    return _decided(scene, state)


def _decided(scene: Scene, state: State) -> tuple[np.ndarray, np.ndarray, tuple[Reason, ...]]:
    return decide(scene, state, ceiling_of(model_fit(scene, state)))


def carried_on(scene: Scene, given: np.ndarray) -> Int[np.ndarray, " trajectories"]:
    """The label that most points of each trajectory have, one trajectory a label in any frame."""
    t = scene.trajectories
    frame, slot = np.nonzero(t.index != NO_MATCH)
    label = given[frame, t.column[frame, slot]]
    votes = np.zeros((len(t), scene.model.num_markers))
    named = label != NO_MATCH
    np.add.at(votes, (t.index[frame, slot][named], label[named]), 1.0)
    return assign_labels(votes, t.start, t.stop)


def _share(scene: Scene, state: State) -> float:
    """What the labels are worth, as a share of what those of a body in full view usually are."""
    return state.worth / (scene.trajectories.num_frames * float(scene.body.usual_evidence.clip(1.0).sum()))
