"""Segments of a model as the matcher sees them, with the tolerances of the method."""

from dataclasses import replace
from itertools import permutations

import numpy as np
from jaxtyping import Float

from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._geometry import pair_distances
from dshpm_jax._model import Segment, SubjectModel, pair_tolerance
from dshpm_jax._requests import Target
from dshpm_jax._settings import Settings
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH


def make_targets(model: SubjectModel, settings: Settings, tuning: Tuning = TUNING) -> list[Target]:
    """A target for every segment of `model`."""
    tolerance = None
    if settings.method == "full":
        tolerance = pair_tolerance(model, settings.spread_factor, settings.tolerance_floor, settings.tolerance_ratio)
    return [_make_target(model, s, settings, tuning, tolerance) for s in range(len(model.segments))]


def _make_target(model: SubjectModel, s: int, settings: Settings, tuning: Tuning, learnt: np.ndarray | None) -> Target:
    segment = model.segments[s]
    ids = np.array(segment.markers)
    distance = pair_distances(segment.shape)
    edge = mean_edge(distance)
    ratio = segment.distortion_ratio if settings.distortion_ratio is None else settings.distortion_ratio
    if learnt is None:
        # Our reading of Eq. 3: a share of the distance, never under the noise of the measurement.
        tolerance = np.maximum(ratio * distance, settings.measurement_noise)
        scale = np.full(len(ids), max(settings.quality_ratio * ratio * edge, settings.measurement_noise))
        reach = np.full(len(ids), max(ratio * edge, settings.measurement_noise))
    else:
        mean, tolerance = model.pair_mean[np.ix_(ids, ids)], learnt[np.ix_(ids, ids)]
        # Markers that were never seen together, as they were worn on different days, are where the shape has them.
        tolerance = np.where(np.isfinite(mean), tolerance, np.maximum(ratio * distance, settings.tolerance_floor))
        distance = np.where(np.isfinite(mean), mean, distance)
        np.fill_diagonal(distance, 0.0)
        scale = _off_diagonal_mean(tolerance)
        reach = tuning.reach_ratio * scale
    return Target(s, ids, segment.shape, distance, tolerance, scale, reach, quantity(segment, settings, tuning))


def quantity(segment: Segment, settings: Settings, tuning: Tuning = TUNING) -> int:
    """Markers that a match must hold (Eq. 5): at least the matching quantity, never under 3 where there are 3."""
    share = segment.matching_quantity if settings.matching_quantity is None else settings.matching_quantity
    if settings.method == "full" and settings.matching_quantity is None:
        share = tuning.matching_quantity
    size = len(segment.markers)
    return max(int(np.ceil(share * size - 1e-9)), min(MIN_FIT_POINTS, size))


def with_virtual_join(target: Target, place: Float[np.ndarray, "3"], slack: float) -> Target:
    """`target` with one more column, the centre of the joint with its parent, at `place` in its shape.

    Arguments:
        slack: how far off the centre may be (mm).
    """
    shape = np.concatenate([target.shape, place[None]])
    apart = np.linalg.norm(target.shape - place, axis=1)
    grown = replace(
        target,
        markers=np.append(target.markers, NO_MATCH),
        shape=shape,
        distance=_bordered(target.distance, apart, 0.0),
        tolerance=_bordered(target.tolerance, np.full(len(apart), slack), slack),
        scale=np.append(target.scale, slack),
        reach=np.append(target.reach, 0.0),
    )
    return grown


def symmetries(target: Target, tuning: Tuning = TUNING) -> list[tuple[int, ...]]:
    """Permutations of the markers under which all distances stay within `tuning.symmetry_tolerances`."""
    distance, size = target.distance, len(target.markers)
    if not 3 <= size <= tuning.max_symmetric_markers:
        return []
    found = []
    for permutation in permutations(range(size)):
        moved = sum(k != p for k, p in enumerate(permutation))
        index = list(permutation)
        change = np.abs(distance[np.ix_(index, index)] - distance)
        if moved >= 2 and (change <= tuning.symmetry_tolerances * target.tolerance).all():
            found.append(permutation)
    return found


def _bordered(matrix: np.ndarray, edge: np.ndarray, corner: float) -> np.ndarray:
    return np.block([[matrix, edge[:, None]], [edge[None], np.array([[corner]])]])


def mean_edge(distance: Float[np.ndarray, "points points"]) -> float:
    """Mean distance of two markers of a segment (mm), the scale of Eq. 4."""
    return float(np.mean(_off_diagonal_mean(distance)))


def _off_diagonal_mean(matrix: np.ndarray) -> np.ndarray:
    """Mean of each row without its diagonal; of a single marker, the diagonal."""
    size = len(matrix)
    if size == 1:
        return matrix[0].astype(float)
    return (matrix.sum(1) - np.diag(matrix)) / (size - 1)
