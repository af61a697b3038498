"""Which of two labellings the mean distances of the whole body prefer.

Where labels are exchanged for good, each frame may fit well enough: a marker's neighbours are wrong with it, and
distances in a single frame are soft. The means of all pairs over the recording are not. They compare only trajectories
that both labellings label: how many to label is for the evidence in the frames, as bodies take postures that no model
has seen, and a label must not be dearer or cheaper for it.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.full.mean_distances import label_sums, mean_distances, mean_llr
from dshpm_jax._control.pair_sums import PairSums
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._types import NO_MATCH


def whole_body_gain(
    problem: LabellingProblem, before: Int[np.ndarray, " trajectories"], after: Int[np.ndarray, " trajectories"]
) -> float:
    """What other labels gain by mean distances between the trajectories that both label (nats a frame)."""
    changed = np.flatnonzero(before != after)
    return float(whole_body_gains(problem, before, [(changed, after[changed])])[0]) if len(changed) else 0.0


def whole_body_gains(
    problem: LabellingProblem,
    identity: Int[np.ndarray, " trajectories"],
    moves: Sequence[tuple[Int[np.ndarray, " changed"], Int[np.ndarray, " changed"]]],
) -> Float[np.ndarray, " moves"]:
    """`whole_body_gain` of each move: of some trajectories and their new labels."""
    sums = label_sums(problem.pair_sums, identity, problem.model.num_markers)
    found = []
    for trajectories, labels in moves:
        after = identity.copy()
        after[trajectories] = labels
        both = (identity[trajectories] != NO_MATCH) & (labels != NO_MATCH)
        if not both.any():
            found.append(0.0)
            continue
        touched = np.unique(np.concatenate([identity[trajectories], labels]))
        touched = touched[touched != NO_MATCH]
        rest = sums[:, touched] - _part(problem.pair_sums, identity, trajectories, touched, sums.shape[2])
        kept = trajectories[both]
        one, other = identity.copy(), after
        one[trajectories[~both]] = other[trajectories[~both]] = NO_MATCH
        worth = [
            _worth(problem, rest + _part(problem.pair_sums, labelled, kept, touched, sums.shape[2]), touched)
            for labelled in (one, other)
        ]
        found.append(worth[1] - worth[0])
    return problem.tuning.whole_body_weight / problem.prepared.partners * np.array(found)


def _worth(
    problem: LabellingProblem, sums: Float[np.ndarray, "3 touched markers"], touched: Int[np.ndarray, " touched"]
) -> float:
    """What the mean distances of some markers to all say (nats), each pair once."""
    found, model = mean_distances(sums, problem.pair_sums.frames), problem.model
    llr = found.share * mean_llr(problem.tuning, found, model.pair_mean[touched], model.pair_spread[touched])
    return float(llr.sum() - llr[:, touched].sum() / 2)


def _part(
    pairs: PairSums,
    identity: Int[np.ndarray, " trajectories"],
    trajectories: Int[np.ndarray, " some"],
    touched: Int[np.ndarray, " touched"],
    markers: int,
) -> Float[np.ndarray, "3 touched markers"]:
    """What these trajectories add to the sums of the touched labels."""
    which = pairs.pairs_of(trajectories)
    row = np.full(markers + 1, NO_MATCH)
    row[touched] = np.arange(len(touched))
    one, other = identity[pairs.one[which]], identity[pairs.other[which]]
    again = ~np.isin(pairs.other[which], trajectories)  # the others are here both ways already
    a, b = np.concatenate([one, other[again]]), np.concatenate([other, one[again]])
    values = np.concatenate([pairs.sums[:, which], pairs.sums[:, which[again]]], axis=1)
    named = (row[a] != NO_MATCH) & (b != NO_MATCH) & (a != b)
    code, size = row[a[named]] * markers + b[named], len(touched) * markers
    return np.stack([np.bincount(code, each, size) for each in values[:, named]]).reshape(3, len(touched), markers)
