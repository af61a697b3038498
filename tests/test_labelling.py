"""What a labelling hands out: a recording by marker, and the poses of its segments."""

import numpy as np
from making import make_labelling, make_recording

LABELLING = make_labelling(
    make_recording(labels=("LASI", "RASI", "SACR", "LKNE", "*5")), ("SACR", "LASI", "RASI", "LKNE")
)


def test_a_labelled_recording_keeps_every_point():
    labelling = LABELLING
    recording = labelling.to_recording()
    before, after = (np.sort(x[np.isfinite(x)]) for x in (labelling.recording.points, recording.points))
    np.testing.assert_array_equal(before, after)
    assert recording.labels[: labelling.model.num_markers] == labelling.model.markers
    assert all(label.startswith("*") for label in recording.labels[labelling.model.num_markers :])


def test_each_marker_stands_in_its_column():
    labelling = LABELLING
    recording, identities = labelling.to_recording(), labelling.identities
    for frame, column in zip(*np.nonzero(identities >= 0)):
        found = recording.points[frame, identities[frame, column]]
        np.testing.assert_array_equal(found, labelling.recording.points[frame, column])


def test_poses_carry_the_shapes_onto_the_points():
    labelling = LABELLING
    rotation, translation = labelling.poses
    points = labelling.to_recording().points
    (segment,) = labelling.model.segments
    seen = np.isfinite(points[:, list(segment.markers)]).all(-1)
    assert (np.isfinite(rotation[:, 0]).all((1, 2)) == (seen.sum(1) >= 3)).all()
    placed = np.einsum("fij,mj->fmi", rotation[:, 0], segment.shape) + translation[:, 0, None]
    off = np.where(seen[..., None], points[:, list(segment.markers)] - placed, 0.0)
    posed = np.isfinite(rotation[:, 0]).all((1, 2))
    np.testing.assert_allclose(off[posed].sum(1), 0.0, atol=1e-6)  # least squares: the residuals balance
    np.testing.assert_allclose(np.linalg.det(rotation[posed, 0]), 1.0, atol=1e-9)
