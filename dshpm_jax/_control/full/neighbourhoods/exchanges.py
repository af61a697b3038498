"""Moves that are worth trying: labels exchanged, segments turned onto themselves, labels taken."""

from collections.abc import Iterator
from heapq import nsmallest

import numpy as np

from dshpm_jax._control.full.moves import Move
from dshpm_jax._control.full.neighbourhoods.ejection_chains import propose_takes
from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.full.overlap import chains, overlap_blocks
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._types import NO_MATCH


def propose_moves(problem: LabellingProblem, solution: Solution) -> list[Move]:
    """Exchanges and takes that might pay, the most promising first."""
    identity, llr, count = solution.identity, solution.llr, problem.tuning.max_moves
    moves = [move for kind in (_exchanges, _permutations) for move in kind(problem, identity, llr)]
    moves += propose_takes(problem.trajectories, identity, llr, problem.tuning)
    return nsmallest(count, moves, lambda m: (-m.promise, m.trajectories.tolist(), m.labels.tolist()))


def _exchanges(problem: LabellingProblem, identity: np.ndarray, llr: np.ndarray) -> list[Move]:
    """Labels a and b exchanged among all trajectories that carry one of them and hang together in time.

    Exchanging less would leave two trajectories with one label in some frame.
    """
    named = np.flatnonzero(identity != NO_MATCH)
    label = identity[named]
    moves: dict[tuple, Move] = {}
    for i, k, loss in _near_ties(problem, named, label, llr):
        a, b = sorted((int(label[i]), int(label[k])))
        chain = _chain(problem, identity, a, b, int(named[i]))
        key = (a, b, chain[0])
        if key not in moves or moves[key].promise < -loss:
            moves[key] = Move(chain, np.where(identity[chain] == a, b, a), -loss)
    return list(moves.values())


def _near_ties(
    problem: LabellingProblem, named: np.ndarray, label: np.ndarray, llr: np.ndarray
) -> Iterator[tuple[int, int, float]]:
    """Pairs of places in `named` that share a frame, and what they lose together with each other's labels (nats)."""
    t, own = problem.trajectories, llr[named, label]
    for rows, near, together in overlap_blocks(t.start[named], t.stop[named]):
        crossed = llr[named[rows]][:, label[near]], llr[named[near]][:, label[rows]].T
        loss = own[rows, None] + own[near] - crossed[0] - crossed[1]
        for i, k in zip(*np.nonzero(together & (loss < problem.tuning.max_exchange_loss) & (rows[:, None] < near))):
            yield int(rows[i]), int(near[k]), float(loss[i, k])


def _chain(problem: LabellingProblem, identity: np.ndarray, a: int, b: int, start: int) -> np.ndarray:
    """Trajectories labelled a or b that hang together with `start` through overlaps in time, ascending."""
    t, either = problem.trajectories, np.flatnonzero((identity == a) | (identity == b))
    groups = (either[group] for group in chains(t.start[either], t.stop[either]))
    return next(group for group in groups if start in group)


def _permutations(problem: LabellingProblem, identity: np.ndarray, llr: np.ndarray) -> Iterator[Move]:
    """A segment turned onto itself: a nearly rectangular plate fits four ways, and exchanges pass through worse ones.

    So do two markers that are each other's best neighbour: by the evidence that there is, neither can be elsewhere.
    """
    for move in propose_turns(problem, identity):
        own, labels = move.trajectories, move.labels
        loss = llr[own, identity[own]] - llr[own, labels]
        yield Move(own, labels, -float(loss.mean()))


def propose_turns(problem: LabellingProblem, identity: np.ndarray) -> Iterator[Move]:
    """Every way to turn a labelled segment onto itself."""
    for target, ways in zip(problem.targets, problem.prepared.symmetries):
        own = np.flatnonzero(problem.prepared.owned[target.segment, identity])
        if not len(own):
            continue
        for permutation in ways:
            to = dict(zip(target.markers.tolist(), target.markers[list(permutation)].tolist()))
            yield Move(own, np.array([to[int(label)] for label in identity[own]]), 0.0)
