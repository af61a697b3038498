"""Moves that single assignments cannot make: two labels exchanged, or a label taken from whoever holds it.

A pair of neighbours that carry each other's labels predicts itself: each alone would only get worse. So whole moves
are tried, each judged in the frames that it touches, by the evidence that it makes itself.
"""

from dataclasses import dataclass

import numpy as np

from dshpm_jax._control.evidence import ACCEPT, FrameEvidence, frame_evidence, labels_in
from dshpm_jax._control.scene import Scene
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH

MOVE_FRAMES = 6  # frames in which a move is judged


@dataclass(frozen=True, eq=False)
class Move:
    """New labels for some trajectories; `promise` orders the trying (nats, by today's evidence)."""

    trajectories: np.ndarray
    labels: np.ndarray
    promise: float


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
