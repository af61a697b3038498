"""From first labels to ones that hold: judged over whole lives and assigned in turn, then bettered by moves."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.assignment import any_overlap, assign_labels, margins
from dshpm_jax._control.evidence import (
    ACCEPT,
    FrameEvidence,
    frame_evidence,
    gains,
    labels_in,
    mean_over_lives,
    objective,
)
from dshpm_jax._control.moves import Move, apply_moves, judge_moves
from dshpm_jax._control.proposing import propose_moves
from dshpm_jax._control.scene import Scene
from dshpm_jax._requests import Control, Together
from dshpm_jax._types import NO_MATCH

MAX_ROUNDS = 12

PATIENCE = 3
"""Rounds without a better state after which settling ends: most go round in circles by then."""

HOLD = 0.5
"""Nats that a label must win by to be taken from where it is; without it near ties swap back and forth."""

MOVE_ROUNDS = 6

EVIDENCE_BYTES, EVIDENCE_COPIES = 256 << 20, 3
"""How much evidence may be kept at a time by what settles side by side, and how often each keeps it."""


@dataclass(frozen=True, eq=False)
class State:
    """A labelling of the whole recording and what it is worth.

    Attributes:
        identity: the marker of each trajectory, `NO_MATCH` where unknown.
        evidence: mean evidence of each label for each trajectory, given `identity` (nats).
        worth: total gain; larger is better.
        frames: the evidence in the sampled frames.
    """

    identity: Int[np.ndarray, " trajectories"]
    evidence: Float[np.ndarray, "trajectories markers"]
    worth: float
    frames: FrameEvidence

    @classmethod
    def of(cls, scene: Scene, identity: np.ndarray, frames: np.ndarray, found: FrameEvidence) -> "State":
        """The state of these labels, judged by the evidence that they make in the sampled `frames`."""
        evidence = mean_over_lives(scene, frames, found)
        return cls(identity, evidence, objective(scene, identity, evidence, found), found)


def gain_in_frames(scene: Scene, state: State) -> Float[np.ndarray, "frames markers"]:
    """What the label of each marker pays in each sampled frame (nats), 0 where none has it."""
    gain = np.zeros((len(state.frames.named), scene.model.num_markers))
    frame, slot = np.nonzero(state.frames.named != NO_MATCH)
    label = state.frames.named[frame, slot]
    gain[frame, label] = state.frames.evidence[frame, slot, label] - ACCEPT
    return gain


def usual_gain(scene: Scene) -> Float[np.ndarray, " markers"]:
    """What a right label usually pays in a frame (nats)."""
    return np.maximum(scene.body.usual_evidence - ACCEPT, 1.0)


def model_fit(scene: Scene, state: State) -> float:
    """The evidence that the labels hold against what right ones usually do: about 1 where the model is the subject's.

    Markers without a point count for nothing; where more than half of them are missing, what is left still holds less,
    as it has fewer neighbours. 0 without any label.
    """
    gain = np.maximum(gain_in_frames(scene, state), 0.0)
    given = state.frames.named[state.frames.named != NO_MATCH]
    return float(gain.sum() / usual_gain(scene)[given].sum()) if len(given) else 0.0


def settle(
    scene: Scene,
    identity: np.ndarray,
    frames: np.ndarray,
    before: FrameEvidence | None = None,
    schedule: tuple[float, ...] = (0.0,),
) -> Control:
    """Judges and assigns in turn until nothing changes; returns the best `State` on the way.

    `identity` may give one label to trajectories that share a frame; what that would be worth is no measure.
    """
    best, overlapping = None, any_overlap(identity, scene.trajectories.start, scene.trajectories.stop)
    for margin in schedule:
        since = 0
        for _ in range(MAX_ROUNDS):
            found: FrameEvidence = yield from frame_evidence(scene, frames, labels_in(scene, identity, frames), before)
            state, before = State.of(scene, identity, frames, found), found
            if overlapping:  # but what follows is assigned without any
                state, overlapping = replace(state, worth=-np.inf), False
            if best is None or state.worth > best.worth:
                best, since = state, 0
            else:
                since += 1
            following = _assign(scene, state, margin)
            if (following == identity).all() or (margin == 0 and since >= PATIENCE):
                break
            identity = following
    return best


def settle_best(controls: Sequence[Control], before: FrameEvidence) -> Control:
    """Runs some `settle`, and returns the best `State` of all, the first of equals, and what each is worth.

    As many side by side as memory allows: the evidence of a long recording is large, and each keeps several.

    Arguments:
        before: evidence of the size that each of them keeps.
    """
    at_once = max(1, EVIDENCE_BYTES // (EVIDENCE_COPIES * max(before.evidence.nbytes, 1)))
    best, worth = None, []
    for first in range(0, len(controls), at_once):
        states: list[State] = yield Together(tuple(controls[first : first + at_once]))
        worth += [state.worth for state in states]
        best = max([best, *states] if best else states, key=lambda state: state.worth)
        del states
    return best, worth


def _assign(scene: Scene, state: State, margin: float) -> Int[np.ndarray, " trajectories"]:
    """The best assignment, less what a rival comes within `margin` nats of: another label, or another trajectory
    for the label while this one lives."""
    t = scene.trajectories
    held = state.evidence.copy()
    named = np.flatnonzero(state.identity != NO_MATCH)
    held[named, state.identity[named]] += HOLD
    identity = assign_labels(gains(scene, held), t.start, t.stop)
    if margin > 0:
        named = np.flatnonzero(identity != NO_MATCH)
        identity[named[margins(identity, state.evidence, t.start, t.stop)[named] < margin]] = NO_MATCH
    return identity


def improve(scene: Scene, state: State, frames: np.ndarray) -> Control:
    """Makes moves for as long as they pay."""
    for _ in range(MOVE_ROUNDS):
        moves = propose_moves(scene, state.identity, state.evidence)
        following = yield from make_moves(scene, state, moves, frames)
        if following is state or following.worth <= state.worth:
            return state
        state = following
    return state


def make_moves(scene: Scene, state: State, moves: list[Move], frames: np.ndarray) -> Control:
    """What becomes of `state` with those of `moves` made that pay, better or worse; `state` itself if none does."""
    if not moves:
        return state
    worth = yield from judge_moves(scene, state.identity, moves, frames, state.frames)
    changed = apply_moves(state.identity, moves, worth)
    if (changed == state.identity).all():
        return state
    return (yield from settle(scene, changed, frames, state.frames))
