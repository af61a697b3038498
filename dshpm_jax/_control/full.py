"""The full method: evidence from many key-frames, one assignment for the recording, restarts judged without truth."""

from dataclasses import replace

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.evidence import fewer_frames, sample_frames
from dshpm_jax._control.resolving import resolve
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State, gain_in_frames, improve, settle, settle_best, usual_gain
from dshpm_jax._control.several import tell_apart
from dshpm_jax._control.turning import turn
from dshpm_jax._control.voting import AGREED, DENSER, Votes
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH

MORE_STARTS = (1.3, 2.0, 4.0)
"""So many times the usual number of key-frames are tried besides, in turn, as long as their votes are divided: where
the model says little, as that of a static does, what they lead to is a matter of luck."""

CONSENT = 0.75
"""Of the best of several starts those labels stay that so many of them lead to; the others are as likely wrong."""

COARSE = 0.3
"""Share of the key-frames that are asked first; most recordings need no more."""

HELD = 0.8
"""Where key-frames agree no restarts are needed if their labels hold so much of the evidence that right ones have."""

SOUND = 0.95
"""Nor are more of them asked where the labels hold so much, but where key-frames are at odds a limb may still carry its
labels shifted by one."""

SCHEDULES = ((2.0, 0.0), (6.0, 4.0, 2.0, 0.0))
"""Restarts: the most certain labels (by so many nats) first."""

FEWER = 3
"""Where the labels hold the evidence of sound ones, restarts are judged in every so many-th of the sampled frames, and
in all of them only if they lead farther."""

STAGES = (improve, turn, resolve, improve, tell_apart)
"""What is done to the best start, each a control from a `State` to one that is worth no less."""

PASSES = 3
"""Times that the stages are gone through at most: again where what comes after `turn` led farther, as a leg found may
show that the other is where it should be; and for as long as anything does where labels hold less than `HELD`, as they
grow from few where much is missing."""


def full(scene: Scene) -> Control:
    """Labels a recording; returns the final `State` and the rigid fits that the key-frames took."""
    frames, votes = sample_frames(scene), Votes.none(scene)
    state = yield from _led_by(scene, votes, 1.0, frames)
    if votes.divided:
        return (yield from _best_of_several(scene, state, votes.fits, frames))
    return state, votes.fits


def _best_of_several(scene: Scene, best: State, fits: int, frames: Int[np.ndarray, " frames"]) -> Control:
    """The best `State` of `MORE_STARTS` and the first, without the labels that the others do not lead to; and fits."""
    found = [best.identity]
    for scale in MORE_STARTS:
        votes = Votes.none(scene)
        state = yield from _led_by(scene, votes, scale, frames)
        fits += votes.fits
        found.append(state.identity)
        best = max(best, state, key=lambda one: one.worth)
        del state  # and its evidence, before the next
        if not votes.divided:
            break
    agreed = (np.stack(found) == best.identity).mean(0) >= CONSENT
    return replace(best, identity=np.where(agreed, best.identity, NO_MATCH)), fits


def _led_by(scene: Scene, votes: Votes, scale: float, frames: Int[np.ndarray, " frames"]) -> Control:
    """The `State` that `scale` times the usual number of key-frames and all stages lead to."""
    held = [(yield from _started(scene, votes, scale, frames))]
    for _ in range(PASSES):
        before = held[0].worth
        turned = yield from _through_stages(scene, held, frames)
        if held[0].worth == (turned if _share_held(scene, held[0]) >= HELD else before):
            break
    return held.pop()


def _through_stages(scene: Scene, held: list[State], frames: Int[np.ndarray, " frames"]) -> Control:
    """Replaces the one state in `held` by what all stages make of it; returns what it was worth once turned.

    It is popped, as a state that nobody holds any more frees its evidence, which is large in a long recording.
    """
    improved = turned = None
    for stage in STAGES:
        if stage is improve and held[0].worth == improved:
            continue  # nothing has changed since the moves were tried
        held.append((yield from stage(scene, held.pop(), frames)))
        improved = held[0].worth if stage is improve else improved
        turned = held[0].worth if stage is turn else turned
    return turned


def _started(scene: Scene, votes: Votes, scale: float, frames: Int[np.ndarray, " frames"]) -> Control:
    """The best `State` that key-frames lead to: few of them where these do, else more, and restarts."""
    state = yield from _asked(scene, votes, scale * COARSE, frames)
    for factor in DENSER:
        share = _share_held(scene, state)
        if votes.agreement >= AGREED and share >= HELD:
            return state
        if share >= SOUND or (factor != DENSER[0] and votes.suffice):
            break
        state = yield from _asked(scene, votes, scale * factor, frames)
    if _share_held(scene, state) >= SOUND:
        return (yield from _restarted_in_some(scene, votes.identity, state, frames))
    return (yield from _restarted(scene, votes.identity, state, frames))


def _restarted_in_some(
    scene: Scene, identity: Int[np.ndarray, " trajectories"], state: State, frames: np.ndarray
) -> Control:
    """`_restarted`, but judged in some of the frames as long as these show nothing better."""
    few = fewer_frames(scene, frames, FEWER)
    known = state.frames.rows(np.searchsorted(frames, few))
    there = State.of(scene, state.identity, few, known)
    again = yield from _restarted(scene, identity, there, few)
    if again is there:
        return state
    again = yield from settle(scene, again.identity, frames, state.frames)
    return max(state, again, key=lambda one: one.worth)


def _restarted(scene: Scene, identity: Int[np.ndarray, " trajectories"], state: State, frames: np.ndarray) -> Control:
    """The best `State` that the most certain labels first lead to from `identity`; `state` itself if none is better."""
    restarts = [settle(scene, identity, frames, state.frames, schedule) for schedule in SCHEDULES]
    again, _ = yield from settle_best(restarts, state.frames)
    return max(state, again, key=lambda one: one.worth)


def _asked(scene: Scene, votes: Votes, factor: float, frames: Int[np.ndarray, " frames"]) -> Control:
    """What the votes lead to with so many more key-frames."""
    yield from votes.ask(scene, factor)
    return (yield from settle(scene, votes.identity, frames))


def _share_held(scene: Scene, state: State) -> float:
    """The evidence that the labels hold, against right ones of which every marker is seen in every frame."""
    gain = np.maximum(gain_in_frames(scene, state), 0.0)
    return float(gain.mean(0).sum() / usual_gain(scene).sum())
