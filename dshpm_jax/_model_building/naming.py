"""Readable names for segments that were found from motion."""

from collections.abc import Sequence

import numpy as np

from dshpm_jax._model_building.body_parts import parts_of_each


def segment_names(segments: Sequence[Sequence[int]], names: Sequence[str]) -> list[str]:
    """A part of the body for each segment where its markers' names say one, each part once; else `segment-3`."""
    from scipy.optimize import linear_sum_assignment  # a third of a second, which reading a model need not wait for

    parts_of_marker = parts_of_each(names)
    parts = sorted({part for found in parts_of_marker for part in found})
    votes = np.zeros((len(segments), len(parts)))
    for s, markers in enumerate(segments):
        for k, part in enumerate(parts):
            # A marker that can only be here counts fully, one at a joint half.
            votes[s, k] = sum((part in parts_of_marker[m]) / max(len(parts_of_marker[m]), 1) for m in markers)
        votes[s] /= len(markers)
    found = [f"segment-{s}" for s in range(len(segments))]
    for s, k in zip(*linear_sum_assignment(votes, maximize=True)):
        if votes[s, k] > 0:
            found[s] = parts[k]
    return found
