"""Robust rigid fits of every segment in every frame."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import is_seen, weighted_rigid_fit
from dshpm_jax._model import SubjectModel
from dshpm_jax._types import MIN_FIT_POINTS

MIN_PLANE_SPREAD_MM = 5.0
"""mm, RMS; used in `rigid_poses` and `fill`: if the points of a body are nearer to a line than this, it has no pose; by
hand: labelling asks for more, to trust a match."""

MIN_MARKER_SD_MM = 1.0
"""mm; used in `marker_sd`: if the model has less than this, this counts; by hand."""

LIMITS = (12.0, 6.0, 3.0, 3.0)
"""standard deviations, one a round; used in `rigid_poses`: a marker this far away counts a quarter (Geman-McClure); by
hand: the first rounds bear a start that one wrong marker has spoilt."""


class SegmentPoses(NamedTuple):
    """Segments in frames: rotations, translations (mm), NaN where there is none."""

    rotations: Float[np.ndarray, "frames segments 3 3"]
    translations: Float[np.ndarray, "frames segments 3"]

    def place(
        self, segment: int, local: Float[np.ndarray, "*points 3"], frames: slice | np.ndarray = slice(None)
    ) -> Float[np.ndarray, "frames *points 3"]:
        """Where points of a segment's own frame are in the world (mm)."""
        turned = np.einsum("fij,...j->f...i", self.rotations[frames, segment], local)
        shift = self.translations[frames, segment]
        return turned + shift.reshape(len(shift), *(1,) * (turned.ndim - 2), 3)


def marker_sd(model: SubjectModel, markers: Sequence[int]) -> Float[np.ndarray, "segment_markers"]:
    """Standard deviation of each marker of a segment on it (mm), from the spreads of its distances to the others."""
    spread = model.pair_spread[np.ix_(markers, markers)]
    spread = np.where(np.eye(len(markers), dtype=bool), np.nan, spread)
    known = np.isfinite(spread).any(1)
    found = np.full(len(markers), MIN_MARKER_SD_MM)
    found[known] = np.nanmedian(spread[known], axis=1) / np.sqrt(2)
    return np.maximum(found, MIN_MARKER_SD_MM)


def rigid_poses(model: SubjectModel, points: Float[np.ndarray, "frames markers 3"]) -> SegmentPoses:
    """The robust fit of each segment to its markers, by iteratively reweighted least squares.

    NaN where a segment shows fewer than three markers, or all of them near a line.
    """
    found = [_robust_fit(s.shape, points[:, list(s.markers)], marker_sd(model, s.markers)) for s in model.segments]
    return SegmentPoses(np.stack([r for r, _ in found], axis=1), np.stack([t for _, t in found], axis=1))


def _robust_fit(shape: np.ndarray, points: np.ndarray, sd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rotation, translation = np.full((len(points), 3, 3), np.nan), np.full((len(points), 3), np.nan)
    enough = np.flatnonzero(is_seen(points).sum(1) >= MIN_FIT_POINTS)
    here = points[enough]
    weight = np.broadcast_to(1 / sd**2, here.shape[:2])
    turn, shift, spread = weighted_rigid_fit(shape, here, weight)
    for limit in LIMITS:
        error = np.linalg.norm(np.einsum("fij,mj->fmi", turn, shape) + shift[:, None] - here, axis=-1)
        weight = 1 / (sd * (1 + (np.nan_to_num(error) / (limit * sd)) ** 2)) ** 2
        turn, shift, spread = weighted_rigid_fit(shape, here, weight)
    posed = spread >= MIN_PLANE_SPREAD_MM
    rotation[enough[posed]], translation[enough[posed]] = turn[posed], shift[posed]
    return rotation, translation
