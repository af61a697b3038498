"""Moves that single assignments cannot make: two labels exchanged, or a label taken from whoever holds it.

A pair of neighbours that carry each other's labels predicts itself: each alone would only get worse. So whole moves
are tried, each judged in the frames that it touches, by the evidence that it makes itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._control.full.evidence import FrameEvidence, evidence_after, labels_in
from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.full.whole_body import whole_body_gains
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._geometry import evenly_spaced
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True, eq=False)
class Move:
    """New labels for some trajectories.

    Attributes:
        trajectories, labels: which get which; `NO_MATCH` takes a label away.
        promise: by what moves are ordered for trying, from the evidence that there is (nats).
    """

    trajectories: Int[np.ndarray, " changed"]
    labels: Int[np.ndarray, " changed"]
    promise: float


def around_fixed(problem: LabellingProblem, move: Move) -> Move:
    """What of a move can be made while the labels that are given stay."""
    fixed = problem.fixed
    if fixed.open is None:
        return move
    free = ~fixed.given[move.trajectories]
    trajectories, labels = move.trajectories[free], move.labels[free]
    allowed = fixed.open[trajectories, np.maximum(labels, 0)]
    return Move(trajectories, np.where(allowed, labels, NO_MATCH), move.promise)


def judge_moves(problem: LabellingProblem, solution: Solution, moves: Sequence[Move]) -> Control[np.ndarray]:
    """What each move is worth (nat frames), judged in a few sampled frames of the lives that it touches."""
    t, before = problem.trajectories, solution.evidence
    rows, sizes, lives, labels = [], [], [], []
    for move in moves:
        changed = solution.identity.copy()
        changed[move.trajectories] = move.labels
        alive = _alive(problem, move)
        touched = np.flatnonzero(alive[before.frames])
        picked = touched[evenly_spaced(len(touched), problem.tuning.move_frames, rounded=True)]
        rows.append(picked)
        sizes.append(len(picked))
        lives.append(int(alive.sum()))
        labels.append(labels_in(problem, changed, before.frames[picked]))
    known = before.rows(np.concatenate(rows))
    after = yield from evidence_after(problem, known, np.concatenate(labels))
    difference = _worth(problem, after) - _worth(problem, known)
    difference += after.distance_llr - known.distance_llr
    first = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    whole = whole_body_gains(problem, solution.identity, [(move.trajectories, move.labels) for move in moves])
    return np.add.reduceat(difference, first) / sizes * lives + whole * t.num_frames


def frames_touched(problem: LabellingProblem, move: Move) -> int:
    """In how many frames a move changes a label."""
    return int(_alive(problem, move).sum())


def _alive(problem: LabellingProblem, move: Move) -> Bool[np.ndarray, " frames"]:
    """The frames in which any trajectory of a move lives."""
    t = problem.trajectories
    alive = np.zeros(t.num_frames, bool)
    for j in move.trajectories:
        alive[t.start[j] : t.stop[j]] = True
    return alive


def _worth(problem: LabellingProblem, evidence: FrameEvidence) -> Float[np.ndarray, " frames"]:
    """What the labels given in each frame pay together (nats)."""
    given = np.maximum(evidence.labels, 0)[:, :, None]
    own = np.take_along_axis(evidence.llr, given, axis=2)[:, :, 0].astype(float)
    return np.where(evidence.labels != NO_MATCH, own - problem.tuning.accept_llr, 0.0).sum(1)


def apply_moves(
    identity: Int[np.ndarray, " trajectories"], moves: Sequence[Move], worth: np.ndarray
) -> Int[np.ndarray, " trajectories"]:
    """The moves that pay, the best first, each trajectory and each label moved once."""
    changed = identity.copy()
    used = np.zeros(len(identity), bool)
    labels: set[int] = set()
    for k in np.argsort(-worth, kind="stable"):
        move = moves[k]
        touched = {int(x) for x in (*move.labels, *identity[move.trajectories]) if x != NO_MATCH}
        if worth[k] <= 0:
            break
        if used[move.trajectories].any() or touched & labels:
            continue
        changed[move.trajectories] = move.labels
        used[move.trajectories] = True
        labels |= touched
    return changed
