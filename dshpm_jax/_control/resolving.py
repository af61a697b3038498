"""Segments that are missing or fit badly, looked for again now that the rest of the body stands."""

import numpy as np

from dshpm_jax._control.assignment import assign_labels
from dshpm_jax._control.dynamic import accept
from dshpm_jax._control.evidence import ACCEPT
from dshpm_jax._control.scene import Known, Scene
from dshpm_jax._control.segment import match_segment
from dshpm_jax._control.settling import State, settle
from dshpm_jax._control.voting import key_frames
from dshpm_jax._hierarchy import children
from dshpm_jax._requests import Control, Together
from dshpm_jax._types import NO_MATCH

FRAMES = 6
ROUNDS = 4
LOOSE = 2.0
"""Factor on all tolerances: few points are left to be mistaken for the segment's."""

LACKING = 0.8
"""A segment is missing if it holds less than this share of what the median segment holds of its markers."""

POOR = 0.65
"""A segment fits badly if its labels have less than this share of the evidence that those of the median segment have,
each against what right ones have on average."""

MAX_SEGMENTS = 6  # looked for in one round, the worst first

_Trial = tuple[tuple[int, ...], bool]


def resolve(scene: Scene, state: State, frames: np.ndarray) -> Control:
    """Looks for missing and badly fitting segments again, alone and with all that hangs from them; keeps what pays."""
    loose = scene.loosened(LOOSE)
    failed: set[_Trial] = set()
    for _ in range(ROUNDS):
        trials = [trial for s in wanting(scene, state)[:MAX_SEGMENTS] for trial in _trials(scene, s)]
        trials = [trial for trial in dict.fromkeys(trials) if trial not in failed]
        if not trials:
            return state
        found = yield Together(tuple(_votes(loose, state, *trial) for trial in trials))
        proposals = [_merged(scene, state, found)] + [_merged(scene, state, [one]) for one in found]
        distinct = {p.tobytes(): p for p in proposals if (p != state.identity).any()}
        states = yield Together(tuple(settle(scene, p, frames, state.frames) for p in distinct.values()))
        better = max(states, key=lambda s: s.worth, default=state)
        if better.worth <= state.worth:
            return state
        failed |= set(trials)
        state = better
    return state


def wanting(scene: Scene, state: State) -> list[int]:
    """Segments that hold too few of their markers or fit them badly, the worst first."""
    t, markers = scene.trajectories, scene.model.num_markers
    named = np.flatnonzero(state.identity != NO_MATCH)
    label, life = state.identity[named], (t.stop - t.start)[named] / t.num_frames
    held = np.bincount(label, life, markers)
    gain = np.bincount(label, life * (state.evidence[named, label] - ACCEPT), markers)
    usual = held * np.maximum(scene.usual_evidence - ACCEPT, 1.0)
    share = np.array([held[target.markers].mean() for target in scene.targets])
    fit = np.array([gain[target.markers].sum() / max(usual[target.markers].sum(), 1e-9) for target in scene.targets])
    poor = np.flatnonzero((share < LACKING * np.median(share)) | (fit < POOR * np.median(fit)))
    return sorted(poor.tolist(), key=lambda s: (share[s] * max(fit[s], 0.0), s))


def _trials(scene: Scene, segment: int) -> list[_Trial]:
    """The segment alone, with its joins and without, and with all that hangs from it."""
    chain = tuple(_subtree(scene, segment))
    alone = [((segment,), True), ((segment,), False)]
    return alone if len(chain) == 1 else [*alone, (chain, True), (chain, False)]


def _subtree(scene: Scene, segment: int) -> list[int]:
    """The segment and all that hangs from it, parents before children."""
    return [segment, *(s for child in children(scene.model.segments, segment) for s in _subtree(scene, child))]


def _votes(scene: Scene, state: State, chain: tuple[int, ...], use_joins: bool) -> Control:
    """Matches of a chain of segments in several frames, as votes for labels."""
    frames = key_frames(scene, FRAMES)
    own = np.unique(np.concatenate([scene.targets[s].markers for s in chain]))
    shared = () if not use_joins else scene.model.segments[chain[0]].join
    identity = state.identity
    if not use_joins or len(chain) > 1:  # what is there of the segment may be what is wrong
        identity = np.where(np.isin(identity, np.setdiff1d(own, shared)), NO_MATCH, identity)
    parts = yield Together(tuple(_match_chain(scene, identity, chain, frame, use_joins) for frame in frames))
    votes = np.zeros((len(scene.trajectories), scene.model.num_markers))
    for part in parts:
        named = np.flatnonzero(np.isin(part, own))
        votes[named, part[named]] += 1
    return votes


def _match_chain(scene: Scene, identity: np.ndarray, chain: tuple[int, ...], frame: int, use_joins: bool) -> Control:
    """Labels after matching the chain's segments in one frame; only what was matched here."""
    known = Known.of(scene, identity, found=True)
    matched = np.full(len(identity), NO_MATCH)
    for segment in chain:
        match = yield from match_segment(scene, known, segment, frame, use_joins or segment != chain[0])
        if match is not None:
            accept(scene, known, match)
            there = match.holder != NO_MATCH
            matched[match.holder[there]] = scene.targets[segment].markers[there]
    return matched


def _merged(scene: Scene, state: State, votes: list[np.ndarray]) -> np.ndarray:
    """The state's labels with the votes on top, where a vote outweighs what a trajectory had."""
    t = scene.trajectories
    total = np.sum(votes, axis=0)
    held = np.zeros_like(total)
    named = np.flatnonzero(state.identity != NO_MATCH)
    held[named, state.identity[named]] = 0.5
    return assign_labels((total + held) * (t.stop - t.start)[:, None], t.start, t.stop)
