"""A hash that tells the points of one file from those of others, whatever its columns are called."""

import hashlib
from pathlib import Path

import numpy as np

from dshpm_jax.io._read import raw


def points_hash(path: str | Path) -> str:
    """The hash of all points of a recording's file, frame by frame, in the order of its columns.

    Names, analog samples and what else the file holds do not count. Coordinates count in millimetres and single
    precision, as C3D files hold them.

    Raises:
        ReadError: the file cannot be read.
    """
    points = raw(path).points
    found = hashlib.sha256(repr(points.shape).encode())
    found.update(np.where(np.isnan(points), np.nan, points).astype("<f4").tobytes())  # one NaN for all
    return found.hexdigest()
