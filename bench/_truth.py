"""The truth of a recording as the benches read it: an .npz with `labels`, `xyz`, `units` and `judged`."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from dshpm_jax import Labelling

NEAR = 0.05  # mm, what rounding may move a point
MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0}


def places_of(truth: Mapping[str, np.ndarray]) -> np.ndarray:
    """Where each marker is (frames, labels, 3), in millimetres, NaN where it is missing."""
    return truth["xyz"] * MILLIMETRES[str(truth["units"]).strip().lower()]


def name_of(file: Path, archive: Path) -> str:
    """The name of the truth of a recording below `archive`."""
    return ".".join(file.relative_to(archive).with_suffix("").parts) + ".npz"


def f1(found: Labelling, truth: dict[str, np.ndarray]) -> float:
    """F1 over points; a label counts where it is within rounding of the marker's true place."""
    places = places_of(truth)
    points, identities = found.recording.points, found.identities
    right = given = 0
    for k, name in enumerate(truth["labels"].tolist()):
        if name not in found.model.markers:
            continue
        frame, column = np.nonzero(identities == found.model.markers.index(name))
        fair = truth["judged"][frame, k]
        given += int(fair.sum())
        with np.errstate(invalid="ignore"):
            right += int((np.linalg.norm(points[frame, column] - places[frame, k], axis=1) < NEAR)[fair].sum())
    there = int((np.isfinite(places).all(-1) & truth["judged"]).sum())
    return 2.0 * right / max(given + there, 1)
