"""Whole chains of labels exchanged with their counterparts, where they carry each other's: for good or for a while."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.moves import Move
from dshpm_jax._control.resolving import shortfall
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State, make_moves, usual_gain
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH

ROUNDS = 4

SHORTEST = 0.5
"""Seconds. Where trajectories are short, both legs may be exchanged between two steps."""

MUCH = 0.1  # share of its usual evidence that a spell must lack

MAX_SPELLS = 60  # tried at once, those that lack the most first


def turn(scene: Scene, state: State, frames: np.ndarray) -> Control:
    """Exchanges chains for as long as that pays."""
    for _ in range(ROUNDS):
        moves = [*_for_good(scene, state), *_for_a_while(scene, state, frames)]
        following = yield from make_moves(scene, state, moves, frames)
        if following.worth <= state.worth:
            return state
        state = following
    return state


def _for_good(scene: Scene, state: State) -> Iterator[Move]:
    """Each exchange of chains, over the whole recording."""
    for to in scene.body.turns:
        changed = _exchanged(state, to)
        if len(changed):
            yield Move(changed, to[state.identity[changed]], 0.0)


def _for_a_while(scene: Scene, state: State, frames: Int[np.ndarray, " frames"]) -> list[Move]:
    """Exchanges in spells in which the labels of the chains lack more than they usually do."""
    moves: dict[bytes, Move] = {}
    t, short, usual = scene.trajectories, shortfall(scene, state), usual_gain(scene)
    shortest = max(1, round(SHORTEST * t.rate / np.diff(frames).max(initial=1)))
    for to in scene.body.turns:
        changed = _exchanged(state, to)
        chains = [k for k, target in enumerate(scene.targets) if (to[target.markers] != target.markers).any()]
        expected = sum(usual[scene.targets[k].markers].sum() for k in chains)
        for first, last, excess in _spells(short[chains].sum(0), shortest, MUCH * expected):
            begin, end = frames[first], frames[last]
            inside = np.minimum(t.stop[changed], end + 1) - np.maximum(t.start[changed], begin)
            within = changed[2 * inside > (t.stop - t.start)[changed]]
            if 0 < len(within) < len(changed):
                move = Move(within, to[state.identity[within]], excess)
                moves.setdefault(move.trajectories.tobytes() + move.labels.tobytes(), move)
    return sorted(moves.values(), key=lambda move: -move.promise)[:MAX_SPELLS]


def _spells(lack: Float[np.ndarray, " frames"], shortest: int, least: float) -> Iterator[tuple[int, int, float]]:
    """Halves, quarters and so on of the recording, and those between them, that lack `least` in a frame.

    Yields the first and the last frame, and what the spell lacks more than the recording on average.
    """
    total = np.concatenate([[0.0], np.cumsum(lack)])
    length = len(lack) // 2
    while length >= shortest:
        for first in range(0, len(lack) - length + 1, max(1, length // 2)):
            lacks = float(total[first + length] - total[first])
            if lacks >= least * length and lacks > length * lack.mean():
                yield first, first + length - 1, lacks - length * lack.mean()
        length //= 2


def _exchanged(state: State, to: Int[np.ndarray, " markers"]) -> Int[np.ndarray, " changed"]:
    """The trajectories whose label an exchange changes."""
    return np.flatnonzero((state.identity != NO_MATCH) & (to[state.identity] != state.identity))
