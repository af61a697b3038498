"""What labelling gives: an identity, a confidence and a reason for every trajectory."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import NO_MATCH


class Reason(StrEnum):
    """Why a trajectory has its label or none."""

    MATCHED = "matched with its segment"
    RECRUITED = "recruited near the place that its segment predicts"
    OUTSIDE = "lies where no marker is expected"
    TAKEN = "another trajectory fits its label better"
    AMBIGUOUS = "two labels fit it almost equally well"
    ABANDONED = "not part of any segment that was found; some were not"


@dataclass(frozen=True, eq=False)
class Labelling:
    """The answer for one recording.

    Attributes:
        recording: what was labelled; its points are never changed.
        model: the model it was labelled against.
        trajectories: the unbroken paths that were judged.
        identity: for each trajectory a marker of the model or `NO_MATCH`.
        confidence: for each trajectory, 0 to 1, how sure the decision is.
        reason: for each trajectory, why.
        stats: figures of the run, such as "svd_count" (rigid fits, section 5.2.3).
    """

    recording: Recording
    model: SubjectModel
    trajectories: Trajectories
    identity: Int[np.ndarray, "trajectories"]
    confidence: Float[np.ndarray, "trajectories"]
    reason: tuple[Reason, ...]
    stats: dict[str, Any] = field(default_factory=dict)

    @property
    def identities(self) -> Int[np.ndarray, "frames points"]:
        """The marker of each point of the recording, `NO_MATCH` where unlabelled or not seen."""
        frames, points = self.recording.points.shape[:2]
        found = np.full((frames, points), NO_MATCH, dtype=np.int32)
        frame, slot = np.nonzero(self.trajectories.index != NO_MATCH)
        which = self.trajectories.index[frame, slot]
        found[frame, self.trajectories.column[frame, slot]] = self.identity[which]
        return found
