"""A recording of a subject of whom nothing is labelled: the population first, then the full method from its labels."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.full.confidence import FinalLabels, finalise
from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.full.search import improved_from
from dshpm_jax._control.full.split import split_trajectories
from dshpm_jax._control.prepared_model import prepared
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import Tuning
from dshpm_jax._control.unseen.keep import as_the_population_says
from dshpm_jax._control.unseen.moments import choose_moments
from dshpm_jax._control.unseen.rounds import PopulationLabels, Seen, population_labels
from dshpm_jax._marker_set.marker_set import MarkerSet
from dshpm_jax._marker_set.own_model import own_model
from dshpm_jax._marker_set.tuning import TUNING, SetTuning
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
    markers: MarkerSet,
    settings: Settings,
    tuning: Tuning,
    set_tuning: SetTuning = TUNING,
) -> Control[UnseenLabels]:
    """The labels of one recording of a subject who wears the markers of a set."""
    seen = [Seen(0, moment) for moment in choose_moments(trajectories, set_tuning)]
    permutations = exchanges(markers, settings, tuning)
    found = yield from population_labels(markers, [trajectories], seen, permutations, set_tuning)
    problem = LabellingProblem(trajectories, own_model(markers, found.known), settings, tuning)
    start = found.identity[0].astype(np.int32)
    solution = yield from improved_from(problem, start)
    solution = yield from as_the_population_says(problem, start, solution, markers, found.known, set_tuning)
    problem, solution = yield from split_trajectories(problem, solution)
    return UnseenLabels(problem, solution, found, finalise(problem, solution))


def exchanges(markers: MarkerSet, settings: Settings, tuning: Tuning) -> list[Int[np.ndarray, " markers"]]:
    """What each label becomes when limbs or sides are exchanged, as the typical body has them."""
    return prepared(markers.model, settings, tuning).side_permutations
