"""What the full method changed of the population's labels, judged by the population: what scores lower is undone."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from dshpm_jax._control.full.assignment import any_overlap
from dshpm_jax._control.full.evidence import evidence_after, labels_in
from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.unseen.judge import Handed, Judge
from dshpm_jax._control.unseen.moments import Moment, behaviour
from dshpm_jax._control.unseen.tables import pair_table, score_table
from dshpm_jax._geometry import evenly_spaced
from dshpm_jax._marker_set.marker_set import MarkerSet
from dshpm_jax._marker_set.posterior import Posterior
from dshpm_jax._marker_set.tuning import SetTuning
from dshpm_jax._requests import Control
from dshpm_jax._trajectories import by_marker
from dshpm_jax._types import NO_MATCH

FRAMES, VOLUME_FRAMES = 256, 16
"""count; used in `_worth`: frames in which distances and volumes are measured; by hand: cost."""


def as_the_population_says(
    problem: LabellingProblem,
    before: Int[np.ndarray, " trajectories"],
    solution: Solution,
    markers: MarkerSet,
    known: Posterior,
    tuning: SetTuning,
) -> Control[Solution]:
    """The solution without the changes of the labels `before` that the population is against."""
    table, handed = score_table(markers, known, tuning), Handed.of(markers, tuning)
    identity = solution.identity.copy()
    worth = None
    for changed in _changes(before, identity):
        undone = identity.copy()
        undone[changed] = before[changed]
        undone = problem.fixed.on(undone)
        if any_overlap(undone, problem.trajectories.start, problem.trajectories.stop):
            undone = _without_rivals(problem, undone, changed)
        if worth is None:
            worth = yield from _worth(problem, identity, table, handed, tuning)
        value = yield from _worth(problem, undone, table, handed, tuning)
        if value > worth:
            identity, worth = undone, value
    if (identity == solution.identity).all():
        return solution
    frames = solution.evidence.frames
    evidence = yield from evidence_after(problem, solution.evidence, labels_in(problem, identity, frames))
    return Solution.of(problem, identity, evidence)


def _changes(before: np.ndarray, after: np.ndarray) -> Iterator[Int[np.ndarray, " changed"]]:
    """Trajectories that lost their label, with all others that changed to or from the labels concerned."""
    changed = np.flatnonzero(before != after)
    count = int(max(before.max(initial=0), after.max(initial=0))) + 2  # the last is no label
    one, other = before[changed] % count, after[changed] % count
    real = (before[changed] != NO_MATCH) & (after[changed] != NO_MATCH)
    links = coo_array((np.ones(real.sum()), (one[real], other[real])), shape=(count, count))
    _, group = connected_components(links, directed=False)
    label = np.where(before[changed] != NO_MATCH, one, other)
    for k in dict.fromkeys(group[label].tolist()):
        own = changed[group[label] == k]
        if (before[own] != NO_MATCH).any():
            yield own


def _without_rivals(problem: LabellingProblem, identity: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """The labels less those that a trajectory of `kept` has at the same time."""
    t = problem.trajectories
    identity = identity.copy()
    for j in kept[identity[kept] != NO_MATCH]:
        same = (identity == identity[j]) & (t.start < t.stop[j]) & (t.start[j] < t.stop)
        same[kept] = False
        identity[same] = NO_MATCH
    return identity


def _worth(
    problem: LabellingProblem, identity: np.ndarray, table: np.ndarray, handed: Handed, tuning: SetTuning
) -> Control[float]:
    """What the population says of all labels of a recording: a pair counts for the share of frames that show it."""
    t = problem.trajectories
    frames = evenly_spaced(t.num_frames, FRAMES)
    places = by_marker(t.points[frames], labels_in(problem, identity, frames), problem.model.num_markers)
    mean, spread, count = behaviour(places)
    some = places[evenly_spaced(len(places), VOLUME_FRAMES)]
    everything = np.arange(problem.model.num_markers)
    moment = Moment(0, everything, mean, spread, count, some)
    judge = Judge(moment, pair_table(moment, table, tuning), handed, tuning)
    judge.pairs.weight[...] *= (count / len(frames))[..., None]
    labels = np.where(np.isfinite(places[..., 0]).any(0), everything, NO_MATCH)
    missing = np.where(labels == NO_MATCH, 1.0, 1.0 - np.diagonal(count) / len(frames)).sum()
    value = judge.total(labels) - (labels == NO_MATCH).sum() * judge.pairs.unlabelled
    volumes = yield from judge.volumes(labels[None])
    return float(judge.temper * (value + missing * judge.pairs.unlabelled) + volumes[0])
