"""Two near labels exchanged for as long as their trajectories hang together in time, or one in the other's place.

The evidence that there is forbids many an exchange that would be right once made: the neighbours of two markers that
carry each other's labels were judged by these. So the mean distances say which are worth a look.
"""

from heapq import nlargest

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.full.mean_distances import MeanDistances, label_sums, mean_distances, mean_llr
from dshpm_jax._control.full.moves import Move
from dshpm_jax._control.full.objective import Incumbent
from dshpm_jax._control.full.overlap import chains
from dshpm_jax._control.full.refine import make_moves
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._requests import Control


def swap_near(problem: LabellingProblem, incumbent: Incumbent) -> Control[None]:
    """Exchanges near labels for as long as that pays."""
    for _ in range(problem.tuning.max_side_rounds):
        moves = propose_near_swaps(problem, incumbent.solution.identity)
        following = yield from make_moves(problem, incumbent.solution, moves)
        if not incumbent.offer(problem, following):
            return


def propose_near_swaps(problem: LabellingProblem, identity: Int[np.ndarray, " trajectories"]) -> list[Move]:
    """The swaps that mean distances do not forbid, the best of them first."""
    if not len(problem.prepared.near_pairs):
        return []
    t, gains, moves = problem.trajectories, _gains(problem, identity), []
    for k in np.flatnonzero(gains > -problem.tuning.max_near_loss):
        a, b = problem.prepared.near_pairs[k]
        either = np.flatnonzero((identity == a) | (identity == b))
        for chain in (either[group] for group in chains(t.start[either], t.stop[either])):
            moves.append(Move(chain, np.where(identity[chain] == a, b, a).astype(np.int32), float(gains[k])))
    return nlargest(problem.tuning.max_near_swaps, moves, key=lambda move: move.promise)


def _gains(problem: LabellingProblem, identity: Int[np.ndarray, " trajectories"]) -> Float[np.ndarray, " pairs"]:
    """What the mean distances say for each two near labels exchanged over the whole recording (nats a frame)."""
    model, tuning = problem.model, problem.tuning
    sums = label_sums(problem.pair_sums, identity, model.num_markers)
    found = mean_distances(sums, problem.pair_sums.frames)
    one, other = problem.prepared.near_pairs.T

    def said(labelled: np.ndarray, as_if: np.ndarray) -> Float[np.ndarray, " pairs"]:
        part = MeanDistances(*(table[labelled] for table in found))
        llr = part.share * mean_llr(tuning, part, model.pair_mean[as_if], model.pair_spread[as_if])
        for apart in (one, other):  # how far the two are from each other does not change
            llr[np.arange(len(one)), apart] = 0.0
        return llr.sum(1)

    gain = said(one, other) + said(other, one) - said(one, one) - said(other, other)
    there = found.share.max(1)
    weight = tuning.whole_body_weight / problem.prepared.partners
    return weight * gain / np.maximum(np.maximum(there[one], there[other]), 1.0 / problem.pair_sums.frames)
