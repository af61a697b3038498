"""Small recordings, models and labellings for the tests of files and of the command."""

from collections.abc import Sequence

import numpy as np

from dshpm_jax import Labelling, Reason, Recording, Segment, SubjectModel
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH


def make_recording(frames: int = 20, labels: Sequence[str] = ("LASI", "RASI", "SACR", "*4"), seed: int = 0, **fields):
    """Points on smooth paths, exact in single precision, with gaps; the first column is seen throughout."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1000, 1000, (1, len(labels), 3)) + rng.normal(0, 5, (frames, len(labels), 3)).cumsum(0)
    points = points.astype(np.float32).astype(np.float64)
    points[rng.random((frames, len(labels))) < 0.1] = np.nan
    points[:, 0] = rng.uniform(100, 200, 3).astype(np.float32)
    return Recording(points, tuple(labels), fields.pop("rate", 100.0), **fields)


def make_model(markers: Sequence[str]) -> SubjectModel:
    rng = np.random.default_rng(1)
    n = len(markers)
    mean = rng.uniform(10, 900, (n, n)).round(4)
    mean = np.triu(mean, 1) + np.triu(mean, 1).T
    spread = np.where(np.eye(n) > 0, np.nan, 1.5)
    segment = Segment("body", tuple(range(n)), rng.normal(0, 100, (n, 3)).round(4))
    return SubjectModel(
        markers=tuple(markers),
        segments=(segment,),
        pair_mean=mean,
        pair_spread=spread,
        sources=("walk.c3d",),
    )


def make_labelling(recording: Recording, markers: Sequence[str], links=None, names=None) -> Labelling:
    """Gives each trajectory the label of the column that it starts in (or of `names`), where the model has it."""
    tracks = from_columns(recording.points, recording.rate, links)
    column = tracks.column[tracks.start, tracks.slot]
    names = [recording.labels[c] for c in column] if names is None else names
    identity = np.array([markers.index(n) if n in markers else NO_MATCH for n in names])
    reason = tuple(Reason.OUTSIDE if k == NO_MATCH else Reason.MATCHED for k in identity)
    return Labelling(
        recording, make_model(markers), tracks, identity, np.full(len(tracks), 0.875), reason, {"svd_count": 12}
    )
