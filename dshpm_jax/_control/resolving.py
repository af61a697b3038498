"""Segments that are missing or fit badly, looked for again now that the rest of the body stands."""

import numpy as np
from jaxtyping import Bool, Float

from dshpm_jax._control.assignment import assign_labels
from dshpm_jax._control.dynamic import accept
from dshpm_jax._control.evidence import FrameEvidence, holders, of_neighbours
from dshpm_jax._control.scene import Known, Scene
from dshpm_jax._control.segment import match_segment
from dshpm_jax._control.settling import State, gain_in_frames, settle, settle_best, usual_gain
from dshpm_jax._control.taking import TAKE_FLOOR
from dshpm_jax._hierarchy import subtree
from dshpm_jax._kernels.life_evidence import MIN_DISTANCES
from dshpm_jax._requests import Control, Together
from dshpm_jax._types import NO_MATCH

FRAMES = 8
ROUNDS = 6
LOOSE = 2.0
"""Factor on all tolerances: few points are left to be mistaken for the segment's."""

POOR = 0.65
"""A segment is poor in a frame if its labels have less than this share of the evidence that those of the recording have
on average, each against what right ones usually have."""

RARELY = 0.03  # a segment may be poor in so many of the frames

MAX_SEGMENTS = 6  # looked for in one round, the worst first

_Trial = tuple[tuple[int, ...], bool]


def resolve(scene: Scene, state: State, frames: np.ndarray) -> Control:
    """Looks for missing and badly fitting segments again, alone and with all that hangs from them; keeps what pays."""
    loose = scene.loosened(LOOSE)
    for _ in range(ROUNDS):
        poor = poor_frames(scene, state, frames)
        trials = [trial for s in list(poor)[:MAX_SEGMENTS] for trial in _trials(scene, s)]
        if not trials:
            return state
        votes = yield Together(tuple(_votes(loose, state, *trial, poor[trial[0][0]]) for trial in trials))
        better, worth = yield from _settled(scene, state, frames, [[one] for one in votes])
        pays = [one for one, found in zip(votes, worth) if found > state.worth]
        if len(pays) > 1:
            together, _ = yield from _settled(scene, state, frames, [pays])
            better = max(better, together, key=lambda s: s.worth)
        if better.worth <= state.worth:
            return state
        state = better
    return state


def _settled(scene: Scene, state: State, frames: np.ndarray, votes: list[list[np.ndarray]]) -> Control:
    """The best that becomes of `state` with a set of votes on top, and what it is worth with each of them."""
    proposals = [_merged(scene, state, some) for some in votes]
    distinct = {p.tobytes(): p for p in proposals if (p != state.identity).any()}
    if not distinct:
        return state, [state.worth] * len(proposals)
    best, worth = yield from settle_best(
        [settle(scene, p, frames, state.frames) for p in distinct.values()], state.frames
    )
    after = dict(zip(distinct, worth))
    return best, [after.get(p.tobytes(), state.worth) for p in proposals]


def poor_frames(scene: Scene, state: State, frames: np.ndarray) -> dict[int, list[int]]:
    """Some frames in which a segment is missing or fits badly, for every such segment, the worst first."""
    short = shortfall(scene, state)
    order = np.argsort(-short.sum(1), kind="stable")
    return {int(s): _spread(frames[short[s] > 0]) for s in order if (short[s] > 0).mean() > RARELY}


def shortfall(scene: Scene, state: State) -> Float[np.ndarray, "segments frames"]:
    """What the labels of a segment lack in each sampled frame (nats), where it is poor.

    Frames in which its markers are merely hidden do not count: nothing would be found there.
    """
    gain, usual = gain_in_frames(scene, state), usual_gain(scene)
    unsettled = _unsettled(scene, state.frames, gain)
    held = np.stack([gain[:, target.markers].sum(1) for target in scene.targets])
    expected = np.array([usual[target.markers].sum() for target in scene.targets])[:, None]
    there = held > 0  # where most of the body is missing, all that is missing would be as good as the average
    average = np.median((held / expected)[there]) if there.any() else 1.0
    short = np.maximum(POOR * average * expected - held, 0.0)
    return short * np.stack([unsettled[:, target.markers].any(1) for target in scene.targets])


def _unsettled(
    scene: Scene, found: FrameEvidence, gain: Float[np.ndarray, "frames markers"]
) -> Bool[np.ndarray, "frames markers"]:
    """Markers that may be elsewhere in a frame than where they are, or that may be there at all.

    Their label does not pay; or they have none, and a point without label might be theirs, or too few of their
    neighbours are known to tell.
    """
    held = holders(found.named, scene.model.num_markers) != NO_MATCH
    known = of_neighbours(scene, held).sum(-1)
    unnamed = np.where((found.named == NO_MATCH)[..., None], found.evidence, -np.inf).max(1)
    return np.where(held, gain < 0, (unnamed > TAKE_FLOOR) | (known < MIN_DISTANCES))


def _spread(frames: np.ndarray) -> list[int]:
    """A few of the frames, from the first to the last."""
    picked = np.linspace(0, len(frames) - 1, min(FRAMES, len(frames)) + 2)[1:-1].round().astype(int)
    return frames[np.unique(picked)].tolist()


def _trials(scene: Scene, segment: int) -> list[_Trial]:
    """The segment alone, with its joins and without, and with all that hangs from it."""
    chain = tuple(subtree(scene.model.segments, segment))
    alone = [((segment,), True), ((segment,), False)]
    return alone if len(chain) == 1 else [*alone, (chain, True), (chain, False)]


def _votes(scene: Scene, state: State, chain: tuple[int, ...], use_joins: bool, frames: list[int]) -> Control:
    """Matches of a chain of segments in several frames, as votes for labels."""
    own = np.unique(np.concatenate([scene.targets[s].markers for s in chain]))
    shared = () if not use_joins else scene.model.segments[chain[0]].join
    identity = state.identity
    if not use_joins or len(chain) > 1:  # what is there of the segment may be what is wrong
        identity = np.where(np.isin(identity, np.setdiff1d(own, shared)), NO_MATCH, identity)
    parts = yield Together(tuple(_match_chain(scene, identity, chain, frame, use_joins) for frame in frames))
    votes = np.zeros((len(scene.trajectories), scene.model.num_markers), np.uint8)  # of `FRAMES`; there are many trials
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
    held = np.zeros(total.shape)
    named = np.flatnonzero(state.identity != NO_MATCH)
    held[named, state.identity[named]] = 0.5
    return assign_labels((total + held) * (t.stop - t.start)[:, None], t.start, t.stop)
