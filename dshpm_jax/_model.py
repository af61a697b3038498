"""The subject's articulated marker model on the host."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._hierarchy import Segment


@dataclass(frozen=True, eq=False)
class SubjectModel:
    """Markers of one subject, how their distances behave, and the segments that they form.

    Attributes:
        markers: names; the position in this tuple is the marker's identity.
        segments: nearly rigid groups that cover all markers and may share some (section 3.1).
        pair_mean, pair_spread: mean and standard deviation of the distance of two markers over the model's
            recordings (mm), NaN for a pair never seen together.
        pair_low, pair_high: smallest and largest such distance (mm).
        pair_frames: in how many frames the pair was seen together.
        sources: names of the recordings that it was made from.
    """

    markers: tuple[str, ...]
    segments: tuple[Segment, ...]
    pair_mean: Float[np.ndarray, "markers markers"]
    pair_spread: Float[np.ndarray, "markers markers"]
    pair_low: Float[np.ndarray, "markers markers"]
    pair_high: Float[np.ndarray, "markers markers"]
    pair_frames: Int[np.ndarray, "markers markers"]
    sources: tuple[str, ...] = field(default=())

    @property
    def num_markers(self) -> int:
        return len(self.markers)
