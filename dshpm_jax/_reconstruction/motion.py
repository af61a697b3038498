"""What reconstruction gives: where every segment and every joint is in every frame, and how that is known."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._model import SubjectModel
from dshpm_jax._reconstruction.filling import Filled, fill
from dshpm_jax._reconstruction.rigid import SegmentPoses
from dshpm_jax._recording import Recording


class Found(IntEnum):
    """How the pose of a segment in a frame was found; the higher, the better it is known."""

    NONE = 0
    """Too little is known: there is no pose."""
    INTERPOLATED = 1
    """On the way from the pose before a short gap to the pose after it, relative to the parent."""
    ARTICULATED = 2
    """From the markers that are left, the joints with neighbouring segments, and the poses before and after."""
    MEASURED = 3
    """From three or more markers of its own."""


@dataclass(frozen=True, eq=False)
class Motion:
    """The reconstructed motion of one labelled recording. Lengths are millimetres.

    Attributes:
        recording: what it was made from, with a name for each column; its points are never changed.
        model: of the subject.
        rotations, translations: `rotation @ shape + translation` is where the markers of a segment's `shape` are; NaN
            where there is no pose.
        joins: where each segment is joined to its parent: the centre of the joint where the model has one, otherwise
            the middle of the markers that they share; NaN for the root and where neither of the two has a pose.
        residual: root mean square distance of the segment's markers that are seen from where its pose has them; NaN
            where there are none.
        found: a `Found` for each segment in each frame.
    """

    recording: Recording
    model: SubjectModel
    rotations: Float[np.ndarray, "frames segments 3 3"]
    translations: Float[np.ndarray, "frames segments 3"]
    joins: Float[np.ndarray, "frames segments 3"]
    residual: Float[np.ndarray, "frames segments"]
    found: Int[np.ndarray, "frames segments"]

    def filled(self, max_seconds: float | None = None) -> Filled:
        """The recording with the gaps of its markers filled, and a mask of what was filled.

        A marker keeps its place among the markers that go with it, or else on its segment, and what it moved there
        from one end of the gap to the other is spread over the gap, so that the path has no jump. What was measured
        stays as it is. A marker that is never seen, or whose segments have no pose, is not filled.

        Arguments:
            max_seconds: leave longer gaps open; by default none is too long.
        """
        return fill(self.recording, self.model, SegmentPoses(self.rotations, self.translations), max_seconds)
