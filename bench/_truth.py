"""The truth of a recording as the benches read it: an .npz with `labels`, `xyz`, `units` and `judged`."""

from collections.abc import Mapping

import numpy as np

NEAR = 0.05  # mm, what rounding may move a point
MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0}


def places_of(truth: Mapping[str, np.ndarray]) -> np.ndarray:
    """Where each marker is (frames, labels, 3), in millimetres, NaN where it is missing."""
    return truth["xyz"] * MILLIMETRES[str(truth["units"]).strip().lower()]
