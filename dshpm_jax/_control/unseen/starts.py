"""First labellings of a moment: from graduated assignment, and from the shapes that distances span."""

from itertools import product

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import linear_sum_assignment

from dshpm_jax._control.unseen.moments import Moment
from dshpm_jax._requests import Control, PairTable, SoftenLabels
from dshpm_jax._types import NO_MATCH

SHARPNESS = ((0.02, 1.0), (0.1, 1.0))
"""per nat; used in `soft_starts`: each start grows as sharp as this, from this on; by hand."""

STEPS = 30
"""count; steps of a start in which it grows sharper; by hand: cost."""

FAR = 9.0
"""squared standard deviations of a body's coordinates; used in `shape_starts`: a point as far from a marker is none."""


def assigned(benefit: Float[np.ndarray, "points markers"], unlabelled: float) -> Int[np.ndarray, " points"]:
    """The labels of largest total benefit; a point may stay without one."""
    points, markers = benefit.shape
    whole = np.concatenate([benefit, np.full((points, points), unlabelled)], axis=1)
    rows, columns = linear_sum_assignment(whole, maximize=True)
    labels = np.full(points, NO_MATCH)
    labels[rows] = np.where(columns < markers, columns, NO_MATCH)
    return labels


def soft_starts(pairs: PairTable) -> Control[list[np.ndarray]]:
    """Labellings by graduated assignment from equal shares."""
    points, markers = len(pairs.node), len(pairs.table)
    even = np.full((len(SHARPNESS), points, markers), 1.0 / max(points, markers), np.float32)
    sharpness = np.array([np.geomspace(low, high, STEPS) for low, high in SHARPNESS])
    benefit = yield SoftenLabels(pairs, even, sharpness)
    return [assigned(one, pairs.unlabelled) for one in benefit]


def shape_starts(moment: Moment, mean_log: Float[np.ndarray, "markers markers"]) -> list[Int[np.ndarray, " points"]]:
    """Labellings from the shapes that all mean distances span, laid on each other axis by axis."""
    body = _shape(np.exp(mean_log))
    found = _shape(moment.mean)
    labels = []
    for signs in product((1.0, -1.0), repeat=3):
        apart = ((found[:, None] * np.array(signs) - body[None]) ** 2).sum(-1)
        labels.append(assigned(-apart, -FAR))
    return labels


def _shape(distance: Float[np.ndarray, "points points"]) -> Float[np.ndarray, "points 3"]:
    """Places along the three longest axes by classical scaling, of unit standard deviation."""
    known = np.isfinite(distance)
    distance = np.where(known, distance, np.median(distance[known]) if known.any() else 1.0)
    np.fill_diagonal(distance, 0.0)
    count = len(distance)
    centre = np.eye(count) - 1 / count
    values, vectors = np.linalg.eigh(-0.5 * centre @ distance**2 @ centre)
    longest = np.argsort(-values, kind="stable")[:3]
    places = np.zeros((count, 3))
    places[:, : len(longest)] = vectors[:, longest] * np.sqrt(np.maximum(values[longest], 1e-9))
    return places / max(float(places.std()), 1e-9)
