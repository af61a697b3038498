"""The truth of a recording as the benches read it: an .npz with `labels`, `xyz`, `units` and `judged`."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Int

from dshpm_jax import Labelling, SubjectModel
from dshpm_jax._trajectories import Trajectories

NEAR = 0.05  # mm, what rounding may move a point
MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0}


class Counts(NamedTuple):
    """Points that can be judged: with the right label, with any label, and of markers."""

    right: int
    given: int
    there: int

    @property
    def f1(self) -> float:
        return 2.0 * self.right / max(self.given + self.there, 1)


def places_of(truth: Mapping[str, np.ndarray]) -> np.ndarray:
    """Where each marker is (frames, labels, 3), in millimetres, NaN where it is missing."""
    return truth["xyz"] * MILLIMETRES[str(truth["units"]).strip().lower()]


def name_of(file: Path, archive: Path) -> str:
    """The name of the truth of a recording below `archive`."""
    return ".".join(file.relative_to(archive).with_suffix("").parts) + ".npz"


def f1(found: Labelling, truth: Mapping[str, np.ndarray]) -> float:
    """F1 over points; a label counts where it is within rounding of the marker's true place."""
    return counts(found, truth).f1


def counts(found: Labelling, truth: Mapping[str, np.ndarray]) -> Counts:
    """What `f1` is made of."""
    right, fair = _judged(found, truth)
    there = np.isfinite(places_of(truth)).all(-1) & truth["judged"]
    return Counts(int((right & fair).sum()), int(fair.sum()), int(there.sum()))


def judged_trajectories(
    tracks: Trajectories,
    identity: Int[np.ndarray, " trajectories"],
    model: SubjectModel,
    truth: Mapping[str, np.ndarray],
) -> tuple[Int[np.ndarray, " judged"], Bool[np.ndarray, " judged"]]:
    """The labelled trajectories that can be judged, and whether each is right in most of its frames."""
    places, to = places_of(truth), _places_of_markers(model, truth)
    frame, slot = np.nonzero(tracks.index >= 0)
    j = tracks.index[frame, slot]
    frame, slot, j = (each[identity[j] >= 0] for each in (frame, slot, j))
    k = to[identity[j]]
    fair = truth["judged"][frame, k] | (k < 0)  # a label that nobody wears is wrong
    with np.errstate(invalid="ignore"):
        near = np.linalg.norm(tracks.points[frame, slot] - places[frame, k], axis=1) < NEAR
    total, good = (np.bincount(j, each, len(tracks)) for each in (fair, fair & near & (k >= 0)))
    which = np.flatnonzero(total)
    return which, good[which] > 0.5 * total[which]


def _places_of_markers(model: SubjectModel, truth: Mapping[str, np.ndarray]) -> Int[np.ndarray, " markers+1"]:
    """Which place of the truth each marker is, -1 where none; no label is -1 and takes the last."""
    names = truth["labels"].tolist()
    return np.array([names.index(name) if name in names else -1 for name in model.markers] + [-1])


def _judged(
    found: Labelling, truth: Mapping[str, np.ndarray]
) -> tuple[Bool[np.ndarray, "frames points"], Bool[np.ndarray, "frames points"]]:
    """Which points carry a label that is at its true place, and which a label that can be judged there."""
    places = places_of(truth)
    label = _places_of_markers(found.model, truth)[found.identities]
    frame, column = np.nonzero(label >= 0)
    k = label[frame, column]
    right, fair = np.zeros(label.shape, bool), np.zeros(label.shape, bool)
    fair[frame, column] = truth["judged"][frame, k]
    with np.errstate(invalid="ignore"):
        apart = np.linalg.norm(found.recording.points[frame, column] - places[frame, k], axis=1)
    right[frame, column] = apart < NEAR
    return right, fair
