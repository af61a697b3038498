"""Moves that single assignments cannot make: two labels exchanged, or a label taken from whoever holds it.

A pair of neighbours that carry each other's labels predicts itself: each alone would only get worse. So whole moves
are tried, each judged in the frames that it touches, by the evidence that it makes itself.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import nsmallest

import numpy as np

from dshpm_jax._control.evidence import ACCEPT, FrameEvidence, frame_evidence, labels_in
from dshpm_jax._control.overlap import overlap_blocks
from dshpm_jax._control.scene import Scene
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH

EXCHANGE_REACH = 8.0
"""Nats that two trajectories may lose together, by today's evidence, if they exchange labels, for it to be tried."""

TAKE_FLOOR = -8.0
"""Evidence from which on an unlabelled trajectory tries to take a label."""

TRIES = 3  # labels that an unlabelled trajectory tries
LONGEST_SHIFT = 6  # labels that one take passes on
MOVE_FRAMES = 6  # frames in which a move is judged
MAX_MOVES = 100  # moves tried at once, the most promising first


@dataclass(frozen=True, eq=False)
class Move:
    """New labels for some trajectories; `promise` orders the trying (nats, by today's evidence)."""

    trajectories: np.ndarray
    labels: np.ndarray
    promise: float


def propose_moves(scene: Scene, identity: np.ndarray, evidence: np.ndarray) -> list[Move]:
    """Exchanges and takes that might pay, the most promising first."""
    kinds = (_exchanges, _takes, _permutations)
    moves = (move for kind in kinds for move in kind(scene, identity, evidence))
    # A long recording has hundreds of thousands; only the best are kept.
    return nsmallest(MAX_MOVES, moves, lambda m: (-m.promise, m.trajectories.tolist(), m.labels.tolist()))


def _meet(scene: Scene, trajectory: int, others: np.ndarray | slice = slice(None)) -> np.ndarray:
    """Which of `others` share a frame with a trajectory; none does with itself."""
    t = scene.trajectories
    meet = (t.start[others] < t.stop[trajectory]) & (t.start[trajectory] < t.stop[others])
    return meet & (np.arange(len(t))[others] != trajectory)


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
    either = np.flatnonzero((identity == a) | (identity == b))
    reached = np.zeros(len(identity), bool)
    waiting = [start]
    reached[start] = True
    while waiting:
        here = waiting.pop()
        for other in either[_meet(scene, here, either) & ~reached[either]]:
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


def _takes(scene: Scene, identity: np.ndarray, evidence: np.ndarray) -> Iterator[Move]:
    """An unlabelled trajectory takes a label; who held it goes without, or to the best label that is free for it."""
    for j in np.flatnonzero((identity == NO_MATCH) & (evidence.max(1) > TAKE_FLOOR)):
        beside = _meet(scene, int(j))
        for label in np.argsort(-evidence[j], kind="stable")[:TRIES]:
            if evidence[j, label] <= TAKE_FLOOR:
                break
            holders = np.flatnonzero((identity == label) & beside)
            chosen = np.append(holders, j)
            promise = float(evidence[j, label] - evidence[holders, label].sum())
            yield Move(chosen, np.append(np.full(len(holders), NO_MATCH), label), promise)
            if len(holders):
                free = [_best_free(scene, identity, evidence, int(h), int(label)) for h in holders]
                yield Move(chosen, np.array([*free, label]), promise)
                yield from _shifts(scene, identity, evidence, int(j), int(label), holders)


def _shifts(
    scene: Scene, identity: np.ndarray, evidence: np.ndarray, j: int, label: int, displaced: np.ndarray
) -> Iterator[Move]:
    """A take that is passed on: the displaced take their next best label from whoever holds that, and so on.

    A real point beside a limb that belongs to no marker can shift all labels of the limb by one.
    """
    moved, promise = {j: label}, float(evidence[j, label])
    taken = {label}
    while len(displaced) and len(taken) <= LONGEST_SHIFT:
        scores = evidence[displaced].mean(0)
        scores[list(taken)] = -np.inf
        label = int(np.argmax(scores))
        if scores[label] <= TAKE_FLOOR:
            return
        taken.add(label)
        promise += float((evidence[displaced, label] - evidence[displaced, identity[displaced]]).sum())
        moved |= dict.fromkeys(displaced.tolist(), label)
        beside = np.logical_or.reduce([_meet(scene, int(h)) for h in displaced])
        displaced = np.flatnonzero((identity == label) & beside)
        lost = dict.fromkeys(displaced.tolist(), NO_MATCH)
        worth = promise - float(evidence[displaced, label].sum())
        whole = moved | lost
        yield Move(np.array(list(whole)), np.array(list(whole.values())), worth)


def _best_free(scene: Scene, identity: np.ndarray, evidence: np.ndarray, trajectory: int, but: int) -> int:
    taken = identity[_meet(scene, trajectory) & (identity != NO_MATCH)]
    scores = evidence[trajectory].copy()
    scores[taken] = -np.inf
    scores[but] = -np.inf
    best = int(np.argmax(scores))
    return best if scores[best] > TAKE_FLOOR else NO_MATCH


def judge_moves(
    scene: Scene, identity: np.ndarray, moves: list[Move], frames: np.ndarray, before: FrameEvidence
) -> Control:
    """What each move is worth (nat frames), judged in up to `MOVE_FRAMES` sampled frames of the lives it touches."""
    t = scene.trajectories
    rows, sizes, lives, named = [], [], [], []
    for move in moves:
        changed = identity.copy()
        changed[move.trajectories] = move.labels
        alive = np.zeros(t.num_frames, bool)
        for j in move.trajectories:
            alive[t.start[j] : t.stop[j]] = True
        touched = np.flatnonzero(alive[frames])
        picked = touched[np.linspace(0, len(touched) - 1, min(MOVE_FRAMES, len(touched))).round().astype(int)]
        rows.append(picked)
        sizes.append(len(picked))
        lives.append(int(alive.sum()))
        named.append(labels_in(scene, changed, frames[picked]))
    row = np.concatenate(rows)
    known = before.rows(row)
    after = yield from frame_evidence(scene, frames[row], np.concatenate(named), known)
    difference = _worth(after.named, after.evidence) - _worth(known.named, known.evidence)
    difference += after.posture - known.posture
    first = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    return np.add.reduceat(difference, first) / sizes * lives


def _worth(named: np.ndarray, evidence: np.ndarray) -> np.ndarray:
    """Total evidence beyond `ACCEPT` of the labels given in each frame."""
    own = np.take_along_axis(evidence, np.maximum(named, 0)[:, :, None], axis=2)[:, :, 0].astype(float)
    return np.where(named != NO_MATCH, own - ACCEPT, 0.0).sum(1)


def apply_moves(identity: np.ndarray, moves: list[Move], gains: np.ndarray) -> np.ndarray:
    """The moves that pay, the best first, each trajectory and each label moved once."""
    changed = identity.copy()
    used = np.zeros(len(identity), bool)
    labels: set[int] = set()
    for k in np.argsort(-gains, kind="stable"):
        move = moves[k]
        touched = {int(x) for x in (*move.labels, *identity[move.trajectories]) if x != NO_MATCH}
        if gains[k] <= 0:
            break
        if used[move.trajectories].any() or touched & labels:
            continue
        changed[move.trajectories] = move.labels
        used[move.trajectories] = True
        labels |= touched
    return changed
