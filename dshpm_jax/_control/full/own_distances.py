"""What this recording's own distances say of each label: how far its marker is from others while other lives carry it.

The model's spreads are those of its own recordings: soft where these moved much, and off where a marker was put on
again. So the distances between labelled markers are learnt anew from this recording, the model's first and as many of
the recording's as there are; what a trajectory says itself is left out of what it is judged by.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._geometry import pair_distances
from dshpm_jax._trajectories import by_marker
from dshpm_jax._types import NO_MATCH

FRAMES_AT_ONCE = 64  # whose tables of distances are held together


class OwnDistances(NamedTuple):
    """The evidence of the recording's own distances for each trajectory (nats).

    Attributes:
        llr: for its label; 0 where it has none, or where too few distances are known. Where no other life carries the
            label, the distances are the model's alone, and the evidence of the frames stands if that is more.
        margin: by how much this is more than for the best of the other labels that it might have.
    """

    llr: Float[np.ndarray, " trajectories"]
    margin: Float[np.ndarray, " trajectories"]


class _Sums(NamedTuple):
    """Of the distances of pairs: number, sum and sum of squares."""

    number: np.ndarray
    total: np.ndarray
    square: np.ndarray

    @classmethod
    def of(cls, apart: Float[np.ndarray, "frames *pairs"]) -> "_Sums":
        seen = np.isfinite(apart)
        apart = np.where(seen, apart, 0.0)
        return cls(seen.sum(0), apart.sum(0), (apart**2).sum(0))

    def less(self, part: "_Sums") -> "_Sums":
        """Without a part of what the first row sums; the tables of this are used up."""
        for table, mine in zip(self, part, strict=True):
            table[0] -= mine
        return self


def own_distances(problem: LabellingProblem, solution: Solution) -> OwnDistances:
    """What the recording's own distances say of the labels of a solution."""
    t, evidence = problem.trajectories, solution.evidence
    points = t.points[evidence.frames]
    places = by_marker(points, evidence.labels, problem.model.num_markers)
    blocks = range(0, len(places), FRAMES_AT_ONCE)
    apart = np.concatenate([pair_distances(places[k : k + FRAMES_AT_ONCE]) for k in blocks])
    everything = _Sums.of(apart)
    first, last = np.searchsorted(evidence.frames, t.start), np.searchsorted(evidence.frames, t.stop)
    llr, margin = np.zeros((2, len(t)))
    for j in np.flatnonzero((solution.identity != NO_MATCH) & (first < last)).tolist():
        life = slice(first[j], last[j])
        tried = _labels_tried(problem, solution, j)
        others = _Sums(*(table[tried] for table in everything)).less(_Sums.of(apart[life, tried[0]]))
        there = np.linalg.norm(places[life] - points[life, t.slot[j]][:, None], axis=-1)
        there[:, tried[0]] = np.nan
        said = _llr(problem, there, tried, others)
        llr[j], margin[j] = said[0], said[0] - said[1:].max(initial=-np.inf)
        if not others.number[0].any():  # then the recording says nothing of this marker
            llr[j], margin[j] = max(llr[j], solution.llr[j, tried[0]]), max(margin[j], 0.0)
    return OwnDistances(llr, margin)


def _labels_tried(problem: LabellingProblem, solution: Solution, j: int) -> Int[np.ndarray, " labels"]:
    """The label of a trajectory, then the others that fit it best."""
    own = solution.identity[j]
    best = np.argsort(-solution.llr[j], kind="stable")[: problem.tuning.rivals_tried + 1]
    return np.concatenate([[own], best[best != own][: problem.tuning.rivals_tried]])


def _llr(
    problem: LabellingProblem,
    apart: Float[np.ndarray, "frames markers"],
    tried: Int[np.ndarray, " labels"],
    others: _Sums,
) -> Float[np.ndarray, " labels"]:
    """The mean evidence (nats) that a point with these distances to all markers has each of the labels."""
    tuning = problem.tuning
    mean, sd, known = _expected(problem, tried, others)
    use = np.isfinite(apart) & known[:, None]
    miss = np.log1p(((apart - mean[:, None]) / sd[:, None]) ** 2 / tuning.t_dof)
    ratio = np.log(tuning.background_mm / sd)[:, None] - 0.5 * (tuning.t_dof + 1) * miss
    order = np.argsort(np.where(known, sd, np.inf), axis=1, kind="stable")[:, None]
    ratio = np.where(use, np.maximum(ratio, tuning.min_mean_llr), 0.0)
    use, ratio = np.take_along_axis(use, order, 2), np.take_along_axis(ratio, order, 2)
    use &= use.cumsum(2) <= tuning.max_distances
    enough = use.sum(2) >= tuning.min_distances
    return np.where(enough, (ratio * use).sum(2) - problem.prepared.null.reflection_penalty, 0.0).mean(1)


def _expected(
    problem: LabellingProblem, tried: Int[np.ndarray, " labels"], others: _Sums
) -> tuple[np.ndarray, np.ndarray, Bool[np.ndarray, "labels markers"]]:
    """The distances that each label should have to all markers: mean and standard deviation (mm), and if known."""
    model, tuning = problem.model, problem.tuning
    prior, spread = model.pair_mean[tried], model.pair_spread[tried]
    known = np.isfinite(prior)
    prior, spread = np.where(known, prior, 0.0), np.where(known, spread, 0.0)
    count = np.maximum(others.number, 1)
    mean = others.total / count
    variance = np.maximum(others.square / count - mean**2, 0.0)
    weight = tuning.model_frames
    within = (weight * spread**2 + others.number * variance) / (weight + others.number) + tuning.own_noise_mm**2
    between = tuning.pair_noise_mm**2 + (tuning.mean_share * prior) ** 2
    precision = 1.0 / between + others.number / within
    known[np.arange(len(tried)), tried] = False
    return (prior / between + others.number * mean / within) / precision, np.sqrt(within + 1.0 / precision), known
