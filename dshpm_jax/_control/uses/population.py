"""Another subject's model made to fit: scaled as a whole, then made anew from the recording that it labelled."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from dshpm_jax._control.full.confidence import finalise
from dshpm_jax._control.full.key_frames import vote
from dshpm_jax._control.full.neighbourhoods.side_swaps import swap_sides
from dshpm_jax._control.full.objective import Incumbent
from dshpm_jax._control.full.refine import refine_labels
from dshpm_jax._control.full.search import solve
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import Tuning
from dshpm_jax._geometry import is_seen, predict_last
from dshpm_jax._model import Neighbourhood, SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._requests import Control, Gather
from dshpm_jax._settings import Settings
from dshpm_jax._subjects import subjects_of
from dshpm_jax._trajectories import Trajectories, by_marker
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH, NO_PARENT


def rescaled(
    trajectories: Trajectories, model: SubjectModel, settings: Settings, tuning: Tuning
) -> Control[SubjectModel]:
    """The model of the subject that a recording shows, made from another subject's model of the same marker set.

    Every size of `Tuning.sizes` is tried, the best `sizes_chosen` more closely. The best of these is made anew from its
    labels, segment by segment, and once more from those that it then gives.

    Raises:
        ValueError: the model is of several subjects.
    """
    if len(subjects_of(model)) > 1:
        raise ValueError("the model of one subject at a time can be rescaled; this one is of several")
    own = replace(settings, rescale=False)

    def problem(model: SubjectModel) -> LabellingProblem:
        return LabellingProblem(trajectories, model, own, tuning)

    sizes = [model.scaled(factor, tuning.proportions) for factor in np.geomspace(*tuning.sizes).tolist()]
    worth = yield Gather(tuple(_roughly(problem(size)) for size in sizes))
    chosen = [sizes[k] for k in np.argsort(-np.array(worth), kind="stable")[: tuning.sizes_chosen]]
    labels = yield Gather(tuple(_labels(problem(size)) for size in chosen))
    best = int(np.argmax([worth for _, _, worth in labels]))
    tracks, identity, _ = labels[best]
    model = refitted(chosen[best], tracks, identity, tuning.min_refit_frames)
    tracks, identity, _ = yield from _labels(problem(model))
    return refitted(model, tracks, identity, tuning.min_refit_frames)


def _labels(problem: LabellingProblem) -> Control[tuple[Trajectories, np.ndarray, float]]:
    """Trajectories, labels of them that can be trusted, and what all are worth."""
    problem, solution = yield from solve(problem)
    final = yield from finalise(problem, solution)
    return problem.trajectories, final.identity, solution.objective


def _roughly(problem: LabellingProblem) -> Control[float]:
    """What the first labels of a recording are worth."""
    start = yield from vote(problem)
    incumbent = Incumbent((yield from refine_labels(problem, start)))
    yield from swap_sides(problem, incumbent)
    return incumbent.objective


def refitted(model: SubjectModel, trajectories: Trajectories, identity: np.ndarray, min_frames: int) -> SubjectModel:
    """A model of the same markers and segments, made from labelled trajectories.

    What is labelled in fewer than `min_frames` stands where the old model predicts it; if that cannot, the old model
    stays.
    """
    labels = np.where(trajectories.index != NO_MATCH, identity[trajectories.index], NO_MATCH)
    points = by_marker(trajectories.points, labels, model.num_markers)
    seen = is_seen(points).sum(0)
    rare = np.flatnonzero(seen < min_frames)
    points[:, rare] = np.stack([_predicted(model.neighbourhoods[m], points) for m in rare], 1) if len(rare) else 0.0
    if not is_seen(points).any(0).all():
        return model
    segments = {
        s.name: {
            "markers": [model.markers[m] for m in s.markers],
            "parent": None if s.parent == NO_PARENT else model.segments[s.parent].name,
        }
        for s in model.segments
    }
    return SubjectModel.from_recordings([Recording(points, model.markers, trajectories.rate)], segments)


def _predicted(near: Neighbourhood, points: Float[np.ndarray, "frames markers 3"]) -> Float[np.ndarray, "frames 3"]:
    """Where the neighbours of a marker say that it is, NaN where fewer than three of them are seen."""
    around = points[:, list(near.markers)]
    enough = is_seen(around).sum(1) >= MIN_FIT_POINTS
    places = np.full((len(points), 3), np.nan)
    if enough.any():
        places[enough] = predict_last(near.shape, around[enough], 1 / near.distance_sd**2)
    return places
