"""The full method: evidence from many key-frames, one assignment for the recording, restarts judged without truth."""

from dshpm_jax._control.evidence import frame_evidence, labels_in, sample_frames
from dshpm_jax._control.resolving import resolve
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import improve, settle
from dshpm_jax._control.several import tell_apart
from dshpm_jax._control.turning import turn
from dshpm_jax._control.voting import vote
from dshpm_jax._requests import Control, Together

SCHEDULES = ((0.0,), (2.0, 0.0), (6.0, 4.0, 2.0, 0.0))
"""Restarts: from the votes as they are, or the most certain labels (by so many nats) first."""


def full(scene: Scene) -> Control:
    """Labels a recording; returns the final `State` and the rigid fits that the key-frames took."""
    start, fits = yield from vote(scene)
    frames = sample_frames(scene)
    first = yield from frame_evidence(scene, frames, labels_in(scene, start, frames))
    states = yield Together(tuple(settle(scene, start, frames, first, schedule) for schedule in SCHEDULES))
    best = max(states, key=lambda state: state.worth)
    best = yield from improve(scene, best, frames)
    best = yield from turn(scene, best, frames)
    best = yield from resolve(scene, best, frames)
    best = yield from improve(scene, best, frames)
    best = yield from tell_apart(scene, best, frames)
    return best, fits
