"""A recording of a subject of whom nothing is labelled: the population first, then the full method from its labels."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.fixed_labels import FixedLabels
from dshpm_jax._control.full.confidence import FinalLabels, finalise
from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.full.search import improved_from
from dshpm_jax._control.full.split import split_trajectories
from dshpm_jax._control.prepared_model import prepared
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import Tuning
from dshpm_jax._control.unseen.clearness import as_clear_as_the_population
from dshpm_jax._control.unseen.keep import as_the_population_says
from dshpm_jax._control.unseen.moments import choose_moments
from dshpm_jax._control.unseen.rounds import PopulationLabels, Seen, population_labels
from dshpm_jax._marker_set import MarkerSet, Member
from dshpm_jax._marker_set.own_model import own_model
from dshpm_jax._marker_set.posterior import posterior_of_model
from dshpm_jax._marker_set.tuning import TUNING, SetTuning
from dshpm_jax._model import SubjectModel
from dshpm_jax._requests import Control
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import Trajectories


@dataclass(frozen=True, eq=False)
class UnseenLabels:
    """The labels of one recording, and where they come from."""

    problem: LabellingProblem
    solution: Solution
    population: PopulationLabels
    final: FinalLabels


def label_unseen(
    trajectories: Trajectories,
    subject: MarkerSet | Member,
    settings: Settings,
    tuning: Tuning,
    fixed: FixedLabels | None = None,
    set_tuning: SetTuning = TUNING,
) -> Control[UnseenLabels]:
    """The labels of one recording of a subject who wears the markers of a set; labels that are given stay."""
    fixed = fixed or FixedLabels.none(trajectories)
    markers = subject.marker_set if isinstance(subject, Member) else subject
    found = yield from _found([trajectories], subject, settings, tuning, set_tuning)
    model = subject.model if isinstance(subject, Member) else own_model(markers, found.known)
    problem = LabellingProblem(trajectories, model, settings, tuning, fixed=fixed)
    start = fixed.on(found.identity[0].astype(np.int32))
    solution = yield from improved_from(problem, start)
    solution = yield from as_the_population_says(problem, start, solution, markers, found.known, set_tuning)
    problem, solution = yield from split_trajectories(problem, solution)
    final = yield from finalise(problem, solution)
    final = as_clear_as_the_population(problem, final, solution.identity, found.margins, set_tuning)
    return UnseenLabels(problem, solution, found, final)


def find_own_model(
    recordings: Sequence[Trajectories],
    markers: MarkerSet,
    settings: Settings,
    tuning: Tuning,
    sources: tuple[str, ...] = (),
    set_tuning: SetTuning = TUNING,
) -> Control[SubjectModel]:
    """The model of the subject whom all the recordings show."""
    found = yield from _found(recordings, markers, settings, tuning, set_tuning)
    return own_model(markers, found.known, sources)


def _found(
    recordings: Sequence[Trajectories],
    subject: MarkerSet | Member,
    settings: Settings,
    tuning: Tuning,
    set_tuning: SetTuning,
) -> Control[PopulationLabels]:
    """What the population says of the recordings of one subject."""
    markers, known = subject, None
    if isinstance(subject, Member):
        markers, known = subject.marker_set, posterior_of_model(subject.marker_set, subject.model, set_tuning)
    assert isinstance(markers, MarkerSet)
    seen = [Seen(k, moment) for k, t in enumerate(recordings) for moment in choose_moments(t, set_tuning)]
    permutations = exchanges(markers, settings, tuning)
    return (yield from population_labels(markers, recordings, seen, permutations, set_tuning, known))


def exchanges(markers: MarkerSet, settings: Settings, tuning: Tuning) -> list[Int[np.ndarray, " markers"]]:
    """What each label becomes when limbs or sides are exchanged, or a segment is turned onto itself."""
    typical = prepared(markers.model, settings, tuning)
    found = list(typical.side_permutations)
    for target, ways in zip(typical.targets, typical.symmetries, strict=True):
        for way in ways:
            to = np.arange(markers.num_markers)
            to[target.markers] = target.markers[list(way)]
            found.append(to)
    distinct = {to.tobytes(): to for to in found if (to != np.arange(len(to))).any()}
    return list(distinct.values())
