"""Poses between those that the markers give: how a segment stands to its parent before and after."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import Rotation

from dshpm_jax._hierarchy import depth_first
from dshpm_jax._model import Segment
from dshpm_jax._reconstruction.rigid import SegmentPoses
from dshpm_jax._types import NO_PARENT


class Between(NamedTuple):
    """A pose for every segment that has one in any frame.

    Attributes:
        poses: those given, and between them what lies on the way; before the first and after the last, as they are.
        distance: frames to the nearest pose given, infinite where there is none at all.
        gap: frames from the pose before to the pose after, infinite where one of them is not there.
    """

    poses: SegmentPoses
    distance: Float[np.ndarray, "frames segments"]
    gap: Float[np.ndarray, "frames segments"]


def interpolate(
    segments: tuple[Segment, ...], poses: SegmentPoses, given: Bool[np.ndarray, "frames segments"], bridged: float
) -> Between:
    """Poses in all frames, parents first, each turned evenly relative to its parent from one given pose to the next.

    A segment with a joint stays in it. The root, and what hangs from a parent without any pose, is taken in the world;
    so is a gap of up to `bridged` frames where the parent itself is in a longer one: where it then is nobody knows.
    """
    rotations, translations = (np.where(np.isfinite(x), x, np.nan) for x in poses)
    whole = SegmentPoses(rotations, translations)
    distance, gap = np.full((2, *given.shape), np.inf)
    for s in depth_first(segments):
        at = np.flatnonzero(given[:, s])
        if not len(at):
            rotations[:, s], translations[:, s] = np.nan, np.nan
            continue
        frame = np.arange(len(given))
        k = np.searchsorted(at, frame, "right")
        before, after = at[np.maximum(k - 1, 0)], at[np.minimum(k, len(at) - 1)]
        before, after = np.where(k == 0, after, before), np.where(k == len(at), before, after)
        inside = (k > 0) & (k < len(at))
        distance[:, s] = np.where(inside, np.minimum(frame - before, after - frame), np.abs(frame - before))
        gap[:, s] = np.where(inside, after - before, np.where(given[:, s], 0, np.inf))
        share = (frame - before) / np.maximum(after - before, 1) * inside
        parent, free = segments[s].parent, ~given[:, s]
        turned, moved = _from_to(segments[s], whole, s, before[free], after[free], share[free], free)
        if parent != NO_PARENT:
            lost = ~given[:, parent] & (gap[:, parent] > bridged)
            alone = ((lost | lost[before] | lost[after]) & (gap[:, s] <= bridged))[free]
            ends = before[free][alone], after[free][alone], share[free][alone]
            turned[alone], moved[alone] = _in_the_world(whole, s, *ends)
        rotations[free, s], translations[free, s] = turned, moved
    return Between(whole, distance, gap)


def _from_to(
    segment: Segment, whole: SegmentPoses, s: int, before, after, share, free
) -> tuple[np.ndarray, np.ndarray]:
    """Poses of a segment in the frames `free`, each `share` of the way from frame `before` to frame `after`."""
    rotations, translations = whole
    parent = segment.parent
    if parent == NO_PARENT or not np.isfinite(translations[:, parent]).all():
        return _in_the_world(whole, s, before, after, share)
    base, origin = rotations[:, parent], translations[:, parent]
    relative = np.einsum("fji,fjk->fik", base, rotations[:, s])
    turned = base[free] @ _slerp(relative[before], relative[after], share)
    join = segment.virtual_join
    if join is not None:
        return turned, whole.place(parent, join.in_parent, free) - turned @ join.in_segment
    local = np.einsum("fji,fj->fi", base, translations[:, s] - origin)
    between = local[before] + share[:, None] * (local[after] - local[before])
    return turned, origin[free] + np.einsum("fij,fj->fi", base[free], between)


def _in_the_world(whole: SegmentPoses, s: int, before, after, share) -> tuple[np.ndarray, np.ndarray]:
    """Poses of a segment `share` of the way from frame `before` to frame `after`, whatever its parent does."""
    rotations, translations = whole.rotations[:, s], whole.translations[:, s]
    moved = translations[before] + share[:, None] * (translations[after] - translations[before])
    return _slerp(rotations[before], rotations[after], share), moved


def _slerp(start: np.ndarray, end: np.ndarray, share: np.ndarray) -> np.ndarray:
    """The rotation `share` of the way from `start` to `end`."""
    if not len(start):
        return start
    step = Rotation.from_matrix(np.swapaxes(start, -1, -2) @ end).as_rotvec()
    return start @ Rotation.from_rotvec(share[:, None] * step).as_matrix()
