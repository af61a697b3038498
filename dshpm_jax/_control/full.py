"""The full method: evidence from many key-frames, one assignment for the recording, restarts judged without truth."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.assignment import assign_labels, margins
from dshpm_jax._control.dynamic import identify
from dshpm_jax._control.evidence import (
    FrameEvidence,
    frame_evidence,
    gains,
    labels_in,
    mean_over_lives,
    objective,
    sample_frames,
)
from dshpm_jax._control.moves import apply_moves, judge_moves, propose_moves
from dshpm_jax._control.scene import Known, Scene
from dshpm_jax._control.segment import match_segment
from dshpm_jax._requests import Control, Together
from dshpm_jax._types import NO_MATCH

MAX_ROUNDS = 12
SCHEDULES = ((0.0,), (2.0, 0.0), (6.0, 4.0, 2.0, 0.0))
"""Restarts: from the votes as they are, or the most certain labels (by so many nats) first."""

HOLD = 0.5
"""Nats that a label must win by to be taken from where it is; without it near ties swap back and forth."""

MOVE_ROUNDS = 6
RESOLVE_FRAMES = 4
RESOLVE_ROUNDS = 3
LOOSE = 2.0
"""Factor on all tolerances where a missing segment is looked for among the few points that are left."""

LACKING = 0.8
"""A segment is looked for again if it holds less than this share of its markers over the recording."""


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


def full(scene: Scene) -> Control:
    """Labels a recording; returns the final `State` and the rigid fits that the key-frames took."""
    parts = yield Together(tuple(identify(scene, frame) for frame in key_frames(scene)))
    fits = sum(part.fits for part in parts)
    frames = sample_frames(scene)
    start = assign_labels(_votes(scene, [p.identity for p in parts]), scene.trajectories.start, scene.trajectories.stop)
    first = yield from frame_evidence(scene, frames, labels_in(scene, start, frames))
    states = yield Together(tuple(settle(scene, start, frames, first, schedule) for schedule in SCHEDULES))
    best = max(states, key=lambda state: state.worth)
    best = yield from improve(scene, best, frames)
    best = yield from resolve_missing(scene, best, frames)
    best = yield from improve(scene, best, frames)
    return best, fits


def key_frames(scene: Scene) -> list[int]:
    """Frames spread evenly over the recording, each the fullest of its share."""
    seen = (scene.trajectories.index != NO_MATCH).sum(1)
    seen = np.minimum(seen, scene.model.num_markers)
    edges = np.linspace(0, len(seen), min(scene.settings.num_key_frames, len(seen)) + 1).astype(int)
    frames = []
    for first, last in zip(edges[:-1], edges[1:]):
        part = seen[first:last]
        best = np.flatnonzero(part == part.max())
        frames.append(int(first + best[np.argmin(np.abs(best - len(part) / 2))]))
    return frames


def _votes(scene: Scene, identities: list[np.ndarray]) -> Float[np.ndarray, "trajectories markers"]:
    """How many key-frames gave each label to each trajectory."""
    votes = np.zeros((len(scene.trajectories), scene.model.num_markers))
    for identity in identities:
        named = np.flatnonzero(identity != NO_MATCH)
        votes[named, identity[named]] += 1
    return votes


def settle(
    scene: Scene,
    identity: np.ndarray,
    frames: np.ndarray,
    before: FrameEvidence | None = None,
    schedule: tuple[float, ...] = (0.0,),
) -> Control:
    """Judges and assigns in turn until nothing changes; returns the best `State` on the way."""
    best = None
    for margin in schedule:
        for _ in range(MAX_ROUNDS):
            found: FrameEvidence = yield from frame_evidence(scene, frames, labels_in(scene, identity, frames), before)
            evidence = mean_over_lives(scene, frames, found)
            worth = objective(scene, identity, evidence, frames, found.named)
            state, before = State(identity, evidence, worth, found), found
            if best is None or state.worth > best.worth:
                best = state
            following = _assign(scene, state, margin)
            if (following == identity).all():
                break
            identity = following
    return best


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
        if not moves:
            return state
        worth = yield from judge_moves(scene, state.identity, moves, frames, state.frames)
        changed = apply_moves(state.identity, moves, worth)
        if (changed == state.identity).all():
            return state
        following = yield from settle(scene, changed, frames, state.frames)
        if following.worth <= state.worth:
            return state
        state = following
    return state


def resolve_missing(scene: Scene, state: State, frames: np.ndarray) -> Control:
    """Looks for missing segments again, now that the rest stands, for as long as that is worth it."""
    loose = scene.loosened(LOOSE)
    for _ in range(RESOLVE_ROUNDS):
        lacking = _lacking(scene, state.identity)
        if not lacking:
            return state
        at = key_frames(scene)[:: max(1, scene.settings.num_key_frames // RESOLVE_FRAMES)]
        trials = [(segment, use_joins) for segment in lacking for use_joins in (True, False)]
        found = yield Together(tuple(_propose(loose, state, segment, at, joins) for segment, joins in trials))
        proposals = [_merged(scene, state, found)] + [_merged(scene, state, [one]) for one in found]
        proposals = [p for p in _distinct(proposals) if (p != state.identity).any()]
        states = yield Together(tuple(settle(scene, proposal, frames, state.frames) for proposal in proposals))
        better = max(states, key=lambda s: s.worth, default=state)
        if better.worth <= state.worth:
            return state
        state = better
    return state


def _lacking(scene: Scene, identity: np.ndarray) -> list[int]:
    t = scene.trajectories
    named = np.flatnonzero(identity != NO_MATCH)
    share = np.zeros(scene.model.num_markers)
    np.add.at(share, identity[named], (t.stop - t.start)[named] / t.num_frames)
    return [s for s, target in enumerate(scene.targets) if share[target.markers].mean() < LACKING]


def _propose(scene: Scene, state: State, segment: int, frames: list[int], use_joins: bool) -> Control:
    """Matches of one segment in several frames, as votes for labels."""
    identity = state.identity
    if not use_joins:  # what is there of the segment alone may be what is wrong
        identity = np.where(np.isin(identity, scene.targets[segment].markers), NO_MATCH, identity)
    matches = yield Together(
        tuple(
            match_segment(scene, Known.of(scene, identity, found=True), segment, frame, use_joins) for frame in frames
        )
    )
    votes = np.zeros((len(scene.trajectories), scene.model.num_markers))
    for match in matches:
        if match is not None:
            named = match.holder != NO_MATCH
            votes[match.holder[named], scene.targets[segment].markers[named]] += 1
    return votes


def _merged(scene: Scene, state: State, votes: list[np.ndarray]) -> np.ndarray:
    """The state's labels with the votes on top, where a vote outweighs what a trajectory had."""
    t = scene.trajectories
    total = np.sum(votes, axis=0)
    held = np.zeros_like(total)
    named = np.flatnonzero(state.identity != NO_MATCH)
    held[named, state.identity[named]] = 0.5
    return assign_labels((total + held) * (t.stop - t.start)[:, None], t.start, t.stop)


def _distinct(proposals: list[np.ndarray]) -> list[np.ndarray]:
    kept: list[np.ndarray] = []
    for proposal in proposals:
        if not any((proposal == other).all() for other in kept):
            kept.append(proposal)
    return kept
