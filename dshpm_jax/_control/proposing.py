"""Moves that are worth trying: labels exchanged, segments turned onto themselves, labels taken."""

from collections.abc import Iterator
from heapq import nsmallest

import numpy as np

from dshpm_jax._control.moves import Move
from dshpm_jax._control.overlap import overlap_blocks
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.taking import takes
from dshpm_jax._types import NO_MATCH

EXCHANGE_REACH = 8.0
"""Nats that two trajectories may lose together, by today's evidence, if they exchange labels, for it to be tried."""

MAX_MOVES = 100  # moves tried at once, the most promising first


def propose_moves(scene: Scene, identity: np.ndarray, evidence: np.ndarray) -> list[Move]:
    """Exchanges and takes that might pay, the most promising first."""
    kinds = (_exchanges, _permutations)
    moves = [move for kind in kinds for move in kind(scene, identity, evidence)]
    moves += takes(scene.trajectories, identity, evidence, MAX_MOVES)
    return nsmallest(MAX_MOVES, moves, lambda m: (-m.promise, m.trajectories.tolist(), m.labels.tolist()))


def _exchanges(scene: Scene, identity: np.ndarray, evidence: np.ndarray) -> list[Move]:
    """Labels a and b exchanged among all trajectories that carry one of them and hang together in time.

    Exchanging less would leave two trajectories with one label in some frame.
    """
    named = np.flatnonzero(identity != NO_MATCH)
    label = identity[named]
    moves: dict[tuple, Move] = {}
    for i, k, loss in _near_ties(scene, named, label, evidence):
        a, b = sorted((int(label[i]), int(label[k])))
        chain = _chain(scene, identity, a, b, int(named[i]))
        key = (a, b, chain[0])
        if key not in moves or moves[key].promise < -loss:
            moves[key] = Move(chain, np.where(identity[chain] == a, b, a), -loss)
    return list(moves.values())


def _near_ties(
    scene: Scene, named: np.ndarray, label: np.ndarray, evidence: np.ndarray
) -> Iterator[tuple[int, int, float]]:
    """Pairs of places in `named` that share a frame, and what they lose together with each other's labels (nats)."""
    t, own = scene.trajectories, evidence[named, label]
    for rows, near, together in overlap_blocks(t.start[named], t.stop[named]):
        crossed = evidence[named[rows]][:, label[near]], evidence[named[near]][:, label[rows]].T
        loss = own[rows, None] + own[near] - crossed[0] - crossed[1]
        for i, k in zip(*np.nonzero(together & (loss < EXCHANGE_REACH) & (rows[:, None] < near))):
            yield int(rows[i]), int(near[k]), float(loss[i, k])


def _chain(scene: Scene, identity: np.ndarray, a: int, b: int, start: int) -> np.ndarray:
    """Trajectories labelled a or b that hang together with `start` through overlaps in time, ascending."""
    t, either = scene.trajectories, np.flatnonzero((identity == a) | (identity == b))
    reached = np.zeros(len(identity), bool)
    waiting = [start]
    reached[start] = True
    while waiting:
        here = waiting.pop()
        meet = (t.start[either] < t.stop[here]) & (t.start[here] < t.stop[either])
        for other in either[meet & ~reached[either]]:
            reached[other] = True
            waiting.append(int(other))
    return np.flatnonzero(reached)


def _permutations(scene: Scene, identity: np.ndarray, evidence: np.ndarray) -> Iterator[Move]:
    """A segment turned onto itself: a nearly rectangular plate fits four ways, and exchanges pass through worse ones.

    So do two markers that are each other's best neighbour: by today's evidence neither can be anywhere else.
    """
    for target, ways in zip(scene.targets, scene.body.symmetries):
        own = np.flatnonzero(scene.body.owned[target.segment, identity])
        if not len(own):
            continue
        for permutation in ways:
            to = dict(zip(target.markers.tolist(), target.markers[list(permutation)].tolist()))
            labels = np.array([to[int(label)] for label in identity[own]])
            loss = evidence[own, identity[own]] - evidence[own, labels]
            yield Move(own, labels, -float(loss.mean()))
