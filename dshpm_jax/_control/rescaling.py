"""Another subject's model made to fit: scaled as a whole, then made anew from the recording that it labelled."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from dshpm_jax._control.decision import decide
from dshpm_jax._control.evidence import sample_frames
from dshpm_jax._control.full import full
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import settle
from dshpm_jax._control.turning import turn
from dshpm_jax._control.voting import vote
from dshpm_jax._geometry import is_seen, predict_last
from dshpm_jax._model import Neighbourhood, SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._requests import Control, Together
from dshpm_jax._settings import Settings
from dshpm_jax._subjects import subjects_of
from dshpm_jax._trajectories import Trajectories, by_marker
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH, NO_PARENT

FACTORS = np.geomspace(0.82, 1.22, 10)
"""Sizes that are tried: from a child of twelve to a tall man, each within `PROPORTIONS` of the next."""

PROPORTIONS = 0.04
"""Share of a length by which bodies of one height differ, and markers are put on elsewhere."""

CHOSEN = 3  # sizes that are looked at closely

FEW_FRAMES = 20
"""A marker labelled in fewer frames keeps the place that the scaled model gives it."""


def rescale(trajectories: Trajectories, model: SubjectModel, settings: Settings) -> Control:
    """The model of the subject that a recording shows, made from another subject's model of the same marker set.

    Every size of `FACTORS` is tried, the best `CHOSEN` more closely. The best of these is made anew from its labels,
    segment by segment, and once more from those that it then gives.

    Raises:
        ValueError: the model is of several subjects.
    """
    if len(subjects_of(model)) > 1:
        raise ValueError("the model of one subject at a time can be rescaled; this one is of several")

    def scene(model: SubjectModel) -> Scene:
        return Scene(trajectories, model, replace(settings, rescale=False))

    sizes = [model.scaled(factor, PROPORTIONS) for factor in FACTORS.tolist()]
    worth = yield Together(tuple(_roughly(scene(size)) for size in sizes))
    chosen = [sizes[k] for k in np.argsort(-np.array(worth), kind="stable")[:CHOSEN]]
    labels = yield Together(tuple(_labels(scene(size)) for size in chosen))
    best = int(np.argmax([worth for _, worth in labels]))
    model = refitted(chosen[best], trajectories, labels[best][0])
    identity, _ = yield from _labels(scene(model))
    return refitted(model, trajectories, identity)


def _labels(scene: Scene) -> Control:
    """Labels that can be trusted, and what all are worth."""
    state, _ = yield from full(scene)
    return decide(scene, state)[0], state.worth


def _roughly(scene: Scene) -> Control:
    """What the first labels of a scene are worth."""
    start = yield from vote(scene)
    frames = sample_frames(scene)
    state = yield from settle(scene, start, frames)
    state = yield from turn(scene, state, frames)
    return state.worth


def refitted(model: SubjectModel, trajectories: Trajectories, identity: np.ndarray) -> SubjectModel:
    """A model of the same markers and segments, made from labelled trajectories.

    What is labelled too rarely stands where the old model predicts it; if it cannot, the old model it remains.
    """
    labels = np.where(trajectories.index != NO_MATCH, identity[trajectories.index], NO_MATCH)
    points = by_marker(trajectories.points, labels, model.num_markers)
    seen = is_seen(points).sum(0)
    rare = np.flatnonzero(seen < FEW_FRAMES)
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
