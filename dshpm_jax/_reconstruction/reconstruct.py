"""`reconstruct`: from labelled points to the motion of the segments."""

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import is_seen
from dshpm_jax._given import GivenModel, GivenRecording, model_of, recording_of
from dshpm_jax._labelling import Labelling
from dshpm_jax._model import SubjectModel
from dshpm_jax._reconstruction.filling import marker_points
from dshpm_jax._reconstruction.interpolation import interpolate
from dshpm_jax._reconstruction.motion import Found, Motion
from dshpm_jax._reconstruction.rigid import SegmentPoses, rigid_poses
from dshpm_jax._recording import Recording, check_names_apart
from dshpm_jax._types import NO_PARENT

BRIDGED_SECONDS = 1.0
"""s; used in `reconstruct`: if next to nothing is seen of a segment for longer than this, it has no pose then; by
hand."""


def reconstruct(labelled: Labelling | GivenRecording, model: GivenModel | None = None) -> Motion:
    """The pose of every segment in every frame, and the joints between them.

    Robust rigid fits where three markers of a segment are seen. Where they are not, segments are fitted to the markers
    that are left and to their joints with their neighbours; where next to nothing is left, and not for long, they turn
    evenly from the pose before to the pose after. `Motion.found` says which. Beyond the paper, whose pose is the
    rigid fit of one segment in one frame (section 4.5); that is `Labelling.poses`.

    Arguments:
        labelled: a labelling, or a recording whose columns carry the model's names, or its file.
        model: of the subject, or its file; not with a labelling, which has its own.

    Raises:
        ReadError: a file cannot be read.
        ValueError: there is no model, or it knows none of the recording's labels.
    """
    recording, model = _named(labelled, model)
    points = marker_points(recording, model)
    poses = rigid_poses(model, points)
    measured, longest = is_seen(poses.translations), BRIDGED_SECONDS * recording.rate
    way = interpolate(model.segments, poses, measured, longest)
    fitted = np.zeros_like(measured)
    if not measured.all():
        from dshpm_jax._reconstruction.articulated import fit_articulated  # needs jax, which whole recordings do not

        poses, fitted = fit_articulated(model, points, measured, way, recording.rate)
        way = interpolate(model.segments, poses, measured | fitted, longest)
    bridged = ~measured & ~fitted & (way.gap <= longest)
    found = np.select([measured, fitted, bridged], [Found.MEASURED, Found.ARTICULATED, Found.INTERPOLATED], Found.NONE)
    for whole in way.poses:
        whole[found == Found.NONE] = np.nan
    joins, residual = _joins(model, way.poses), _residual(model, points, way.poses)
    return Motion(recording, model, *way.poses, joins, residual, found)


def _named(labelled: Labelling | GivenRecording, model: GivenModel | None) -> tuple[Recording, SubjectModel]:
    if isinstance(labelled, Labelling):
        if model is not None:
            raise ValueError("a labelling has its own model; give no other")
        return labelled.to_recording(), labelled.model
    if model is None:
        raise ValueError("a recording needs the model of its subject; give reconstruct(recording, model)")
    known = model_of(model)
    recording = recording_of(labelled, known)
    if not set(recording.labels) & set(known.markers):
        raise ValueError("none of its labels is in the model; give a labelled recording and the model of its subject")
    check_names_apart(recording, take_turns=False)
    return recording, known


def _joins(model: SubjectModel, poses: SegmentPoses) -> Float[np.ndarray, "frames segments 3"]:
    """The mean of where the parent and the segment itself have each joint, or what one of them says."""
    joins = np.full(poses.translations.shape, np.nan)
    for s, segment in enumerate(model.segments):
        if segment.parent == NO_PARENT:
            continue
        join, parent = segment.virtual_join, model.segments[segment.parent]
        if join is not None:
            in_parent, in_segment = join.in_parent, join.in_segment
        elif segment.join:
            in_parent = parent.shape[[parent.markers.index(m) for m in segment.join]].mean(0)
            in_segment = segment.shape[[segment.markers.index(m) for m in segment.join]].mean(0)
        else:
            continue
        both = np.stack([poses.place(segment.parent, in_parent), poses.place(s, in_segment)])
        known = is_seen(both)[..., None]
        total = np.where(known, both, 0.0).sum(0)
        joins[:, s] = np.where(known.any(0), total / np.maximum(known.sum(0), 1), np.nan)
    return joins


def _residual(model: SubjectModel, points: np.ndarray, poses: SegmentPoses) -> Float[np.ndarray, "frames segments"]:
    found = np.full(poses.translations.shape[:2], np.nan)
    for s, segment in enumerate(model.segments):
        square = ((poses.place(s, segment.shape) - points[:, list(segment.markers)]) ** 2).sum(-1)
        there = np.isfinite(square)
        some = there.any(1)
        found[some, s] = np.sqrt(np.where(there, square, 0.0).sum(1)[some] / there.sum(1)[some])
    return found
