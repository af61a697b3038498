"""How far labelled markers are from each other over the whole recording, and how still they keep.

A pair that hardly moves in this recording has a mean distance that is known to a few millimetres, however soft the
model's recordings were. So it tells which of several near markers is which, where a single frame does not.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from dshpm_jax._control.full.evidence import FrameEvidence
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._geometry import pair_distances
from dshpm_jax._trajectories import by_marker

FRAMES_AT_ONCE = 256  # whose tables of distances are held together


class MeanDistances(NamedTuple):
    """Of every pair of markers as they are labelled, over the sampled frames.

    Attributes:
        share: of the frames, in how many both are labelled.
        mean, sd: of the distance in these (mm), 0 where there are none.
    """

    share: Float[np.ndarray, "markers markers"]
    mean: Float[np.ndarray, "markers markers"]
    sd: Float[np.ndarray, "markers markers"]


def mean_distances(problem: LabellingProblem, evidence: FrameEvidence) -> MeanDistances:
    """The distances between all labelled markers."""
    markers = problem.model.num_markers
    places = by_marker(problem.trajectories.points[evidence.frames], evidence.labels, markers)
    count, total, square = np.zeros((3, markers, markers))
    for first in range(0, len(places), FRAMES_AT_ONCE):
        part = places[first : first + FRAMES_AT_ONCE]
        apart = pair_distances(part)
        seen = np.isfinite(apart)
        apart = np.where(seen, apart, 0.0)
        count += seen.sum(0)
        total += apart.sum(0)
        square += (apart**2).sum(0)
    mean = total / np.maximum(count, 1)
    variance = np.maximum(square / np.maximum(count, 1) - mean**2, 0.0)
    return MeanDistances(count / len(places), mean, np.sqrt(variance))
