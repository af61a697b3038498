"""The full method: evidence from many key-frames, one assignment for the recording, restarts judged without truth."""

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.evidence import sample_frames
from dshpm_jax._control.resolving import resolve
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State, gain_in_frames, improve, settle, settle_best, usual_gain
from dshpm_jax._control.several import tell_apart
from dshpm_jax._control.turning import turn
from dshpm_jax._control.voting import AGREED, DENSER, Votes
from dshpm_jax._requests import Control

COARSE = 0.3
"""Share of the key-frames that are asked first; most recordings need no more."""

SOUND, LIKELY = 0.95, 0.8
"""A labelling that holds so much of the evidence that right labels usually have needs neither more key-frames nor
restarts; where key-frames agree the lower share will do. Most wrong ones stay under .7, but a chain that carries the
labels of its counterpart reaches .92, with key-frames at odds."""

SCHEDULES = ((2.0, 0.0), (6.0, 4.0, 2.0, 0.0))
"""Restarts: the most certain labels (by so many nats) first."""


def full(scene: Scene) -> Control:
    """Labels a recording; returns the final `State` and the rigid fits that the key-frames took."""
    frames = sample_frames(scene)
    votes = Votes.none(scene)
    best = yield from _started(scene, votes, frames)
    best = yield from improve(scene, best, frames)
    best = yield from turn(scene, best, frames)
    best = yield from resolve(scene, best, frames)
    best = yield from improve(scene, best, frames)
    best = yield from tell_apart(scene, best, frames)
    return best, votes.fits


def _started(scene: Scene, votes: Votes, frames: Int[np.ndarray, " frames"]) -> Control:
    """The best `State` that key-frames lead to: few of them where these do, else more, and restarts."""
    state = yield from _asked(scene, votes, COARSE, frames)
    for factor in DENSER:
        if factor == DENSER[0] or not votes.suffice(votes.labels(scene)):
            if _sound(scene, votes, state):
                return state
            state = yield from _asked(scene, votes, factor, frames)
    if _sound(scene, votes, state):
        return state
    start = votes.labels(scene)
    restarts = [settle(scene, start, frames, state.frames, schedule) for schedule in SCHEDULES]
    again, _ = yield from settle_best(restarts, state.frames)
    return max(state, again, key=lambda one: one.worth)


def _asked(scene: Scene, votes: Votes, factor: float, frames: Int[np.ndarray, " frames"]) -> Control:
    """What the votes lead to with so many more key-frames."""
    yield from votes.ask(scene, factor)
    return (yield from settle(scene, votes.labels(scene), frames))


def _sound(scene: Scene, votes: Votes, state: State) -> bool:
    """Whether the labels hold enough evidence, against right ones of which every marker is seen in every frame."""
    gain = np.maximum(gain_in_frames(scene, state), 0.0)
    share = float(gain.mean(0).sum() / usual_gain(scene).sum())
    return share >= (LIKELY if votes.agreement(votes.labels(scene)) >= AGREED else SOUND)
