"""Pre-tracking (section 4.1): from a recording to trajectories."""

import logging

import numpy as np

from dshpm_jax._columns import columns_are_tracks, unbroken_columns
from dshpm_jax._kernels.tracking import track
from dshpm_jax._recording import Recording
from dshpm_jax._trajectories import Trajectories, from_columns

logger = logging.getLogger(__name__)


def pretrack(recording: Recording) -> Trajectories:
    """The trajectories of a recording: its columns, cut where they jump, or tracks where columns mean nothing.

    Every point is in exactly one trajectory, and a gap ends a trajectory.
    """
    points = np.asarray(recording.points, dtype=np.float64)
    if columns_are_tracks(points):
        links = unbroken_columns(points, recording.rate)
    else:
        logger.info("columns carry no trajectories: points are tracked from frame to frame")
        links = track(points, recording.rate)
    return from_columns(points, recording.rate, links)
