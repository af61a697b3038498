"""Labels of near markers permuted for good: a cluster whose labels are shifted by one, or turned, fits itself.

No exchange of two labels leads out of a shift by one, and where a marker of the cluster is not worn, its label is free.
So all permutations of a few near labels are compared by what the mean distances of their trajectories say, from all of
the body and over the whole recording; the best are tried.
"""

from collections.abc import Iterator
from functools import cache
from heapq import nlargest
from itertools import permutations

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.full.mean_distances import MeanDistances, label_sums, mean_distances, mean_llr
from dshpm_jax._control.full.moves import Move
from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._types import NO_MATCH


def propose_permutations(problem: LabellingProblem, solution: Solution) -> Iterator[Move]:
    """The most promising permutations of all clusters, over the whole recording."""
    sums = label_sums(problem.pair_sums, solution.identity, problem.model.num_markers)
    found = mean_distances(sums, problem.pair_sums.frames)
    best: dict[bytes, tuple[float, np.ndarray]] = {}
    for cluster in problem.prepared.clusters:
        for gain, to in _of_cluster(problem, found, cluster):
            key = to.tobytes()
            best[key] = max(best.get(key, (gain, to)), (gain, to), key=lambda one: one[0])
    for gain, to in nlargest(problem.tuning.max_permutations, best.values(), key=lambda one: one[0]):
        changed = np.flatnonzero((solution.identity != NO_MATCH) & (to[solution.identity] != solution.identity))
        if len(changed):
            yield Move(changed, to[solution.identity[changed]], gain)


def _of_cluster(
    problem: LabellingProblem, found: MeanDistances, cluster: Int[np.ndarray, " cluster"]
) -> Iterator[tuple[float, Int[np.ndarray, " markers"]]]:
    """What each label becomes in the best permutations of a cluster, and by how much these are better (nats)."""
    size, here = len(cluster), np.arange(len(cluster))
    orders = _orders(size)
    to_others, inside = _scores(problem, found, cluster)
    score = to_others[here, orders].sum(1)
    score += 0.5 * inside[here[:, None], here, orders[:, :, None], orders[:, None]].sum((1, 2))
    worn = found.share[cluster].max(1) > 0
    for row in np.argsort(score[0] - score, kind="stable")[: problem.tuning.permutations_tried]:
        gain = float(score[row] - score[0])
        if gain >= -problem.tuning.max_permutation_loss and (orders[row] != here)[worn].any():
            to = np.arange(problem.model.num_markers)
            to[cluster] = cluster[orders[row]]
            yield gain, to


@cache
def _orders(size: int) -> Int[np.ndarray, "orders size"]:
    """All permutations of so many things, the identity first."""
    return np.array(list(permutations(range(size))))


def _scores(
    problem: LabellingProblem, found: MeanDistances, cluster: Int[np.ndarray, " cluster"]
) -> tuple[Float[np.ndarray, "cluster cluster"], Float[np.ndarray, "cluster cluster cluster cluster"]]:
    """What distances say if what is labelled as one marker of the cluster is another (nats).

    Returns:
        the distances from all markers outside, for each marker as each other; and those between two markers of the
        cluster, for each two as each other two.
    """
    outside = np.setdiff1d(np.arange(problem.model.num_markers), cluster)
    across, within = np.ix_(cluster, outside), np.ix_(cluster, cluster)
    mean, sd = problem.model.pair_mean, problem.model.pair_spread
    from_others = MeanDistances(*(table[across][:, None] for table in found))
    between = MeanDistances(*(table[within][:, :, None, None] for table in found))
    to_others = _llr(problem, from_others, mean[across], sd[across]).sum(-1)
    return to_others, _llr(problem, between, mean[within], sd[within])


def _llr(
    problem: LabellingProblem, found: MeanDistances, mean: np.ndarray, sd: np.ndarray
) -> Float[np.ndarray, "*pairs"]:
    """The log-likelihood ratio of mean distances (nats), for as many of the frames as there are."""
    return found.share * mean_llr(problem.tuning, found, mean, sd)
