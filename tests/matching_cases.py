"""Random segments to match: seen with noise among other points, with markers missing, rivals and known joins."""

import numpy as np
from reference import NO_MATCH
from scipy.spatial.transform import Rotation

from dshpm_jax._requests import MatchSegment, Target


def make_request(
    rng: np.random.Generator,
    markers: int,
    points: int,
    pins: int = 0,
    virtual: bool = False,
    missing: float = 0.1,
    rivals: int = 1,
) -> MatchSegment:
    """A segment of `markers` in a frame of `points`.

    Arguments:
        pins: how many of its markers are known already; they are the pivots then (section 4.2.1).
        virtual: whether a last column is a virtual join, known and no marker.
        missing: share of the markers that are not seen.
        rivals: how many other groups of points look much like the segment.
    """
    shape = rng.normal(0, 100, (markers + virtual, 3))
    places = [_seen(rng, shape, 1.5)] + [_seen(rng, shape[:markers], 6.0) for _ in range(rivals)]
    own = np.flatnonzero((rng.random(markers + virtual) >= missing) | (np.arange(markers + virtual) < pins))
    if virtual and markers not in own:
        own = np.append(own, markers)
    cloud = np.concatenate([places[0][own], *places[1:], rng.uniform(-1000, 1000, (points, 3))])[:points]
    order = rng.permutation(points)
    cloud = cloud[np.argsort(order)]
    point_of = {int(column): int(order[k]) for k, column in enumerate(own) if k < points}
    pinned = np.full(markers + virtual, NO_MATCH)
    free = rng.random(points) < 0.95
    for column in [*range(pins), *([markers] if virtual else [])]:
        pinned[column] = point_of[column]
    free[pinned[pinned != NO_MATCH]] = False
    return MatchSegment(_target(rng, shape, virtual), cloud, free, _rigid(rng, points), pinned, *_pivots(pinned, free))


def _seen(rng: np.random.Generator, shape: np.ndarray, noise: float) -> np.ndarray:
    turned = shape @ Rotation.random(random_state=rng).as_matrix().T
    return turned + rng.uniform(-800, 800, 3) + rng.normal(0, noise, shape.shape)


def _target(rng: np.random.Generator, shape: np.ndarray, virtual: bool) -> Target:
    size = len(shape)
    distance = np.linalg.norm(shape[:, None] - shape[None], axis=-1)
    tolerance = np.maximum(0.1 * distance, 4.0)
    markers = rng.permutation(size)
    if virtual:
        markers[-1] = NO_MATCH
    need = max(int(np.ceil(0.7 * (size - virtual))), min(3, size - virtual))
    return Target(0, markers, shape, distance, tolerance, rng.uniform(4, 8, size), rng.uniform(8, 20, size), need)


def _rigid(rng: np.random.Generator, points: int) -> np.ndarray:
    """A symmetric matrix with some pairs ruled out."""
    ruled_out = np.triu(rng.random((points, points)) < 0.03, 1)
    return ~(ruled_out | ruled_out.T)


def _pivots(pinned: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Known columns are the pivots; where none is known, every column is, at every free point."""
    known = np.flatnonzero(pinned != NO_MATCH)
    if len(known):
        return known, pinned[known]
    pivot, assumed = np.meshgrid(np.arange(len(pinned)), np.flatnonzero(free), indexing="ij")
    return pivot.ravel(), assumed.ravel()
