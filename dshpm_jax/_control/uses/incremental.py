"""A piece of a recording whose beginning is labelled: the labels go on, and what is new or lost is looked for."""

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.full.assignment import assign_labels
from dshpm_jax._control.full.confidence import FinalLabels, finalise
from dshpm_jax._control.full.objective import Incumbent, Solution
from dshpm_jax._control.full.refine import improve, refine_labels
from dshpm_jax._control.full.rematch import rematch
from dshpm_jax._control.full.search import search
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH


def update_labels(problem: LabellingProblem, given: Int[np.ndarray, "frames columns"]) -> Control[FinalLabels]:
    """Labels for all trajectories, from those that points have already.

    Trajectories stay whole: the next piece may show what a part of one is.

    Arguments:
        given: labels that points of the recording have already, `NO_MATCH` for the others.
    """
    start = carried_on(problem, given)
    if (start == NO_MATCH).all():
        return (yield from finalise(problem, (yield from search(problem))))
    incumbent = Incumbent((yield from refine_labels(problem, start)))
    yield from improve(problem, incumbent)
    yield from rematch(problem, incumbent)
    if _share(problem, incumbent.solution) < problem.tuning.start_anew_below:
        incumbent.offer(problem, (yield from search(problem)))
    return (yield from finalise(problem, incumbent.solution))


def carried_on(problem: LabellingProblem, given: np.ndarray) -> Int[np.ndarray, " trajectories"]:
    """The label that most points of each trajectory have, one trajectory a label in any frame."""
    t = problem.trajectories
    frame, slot = np.nonzero(t.index != NO_MATCH)
    label = given[frame, t.column[frame, slot]]
    votes = np.zeros((len(t), problem.model.num_markers))
    named = label != NO_MATCH
    np.add.at(votes, (t.index[frame, slot][named], label[named]), 1.0)
    return assign_labels(votes, t.start, t.stop)


def _share(problem: LabellingProblem, solution: Solution) -> float:
    """What the labels are worth, as a share of what those of a body in full view usually are."""
    usual = problem.prepared.expected_llr.clip(problem.tuning.min_usual_gain)
    return solution.objective / (problem.trajectories.num_frames * float(usual.sum()))
