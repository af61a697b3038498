"""What labelling gives: an identity, a confidence and a reason for every trajectory."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._geometry import rigid_fit
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._trajectories import Trajectories, by_marker
from dshpm_jax._types import NO_MATCH


class Reason(StrEnum):
    """Why a trajectory has its label or none.

    The text is what sidecars hold. The first two come with a label, the last with one or none, the others without.
    """

    MATCHED = "matched with its segment"
    RECRUITED = "recruited near the place that its segment predicts"
    OUTSIDE = "lies where no marker is expected"
    TAKEN = "another trajectory fits its label better"
    AMBIGUOUS = "two labels fit it almost equally well"
    DOUBTFUL = "the label that it would get fits too badly to be trusted"
    ABANDONED = "not part of any segment that was found; some were not"
    KNOWN = "known, as a person or the file says so"


WITHHELD = (Reason.AMBIGUOUS, Reason.DOUBTFUL)
"""Why a label is withheld; `Labelling.could_be` has it first then."""


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
        stats: figures of the run: "svd_count" (rigid fits, section 5.2.3), and of the full method "model_fit", the
            evidence that the labels hold against what right ones usually do; see `Tuning.poor_fit_below`. Where the
            labels are doubtful as a whole for other reasons, "doubts" holds these, a short sentence each. Where labels
            were known although the evidence is against them, "against" holds a sentence for each.
        could_be: for each trajectory the markers, besides its label, that it may be: the label that is withheld from
            it, and the one that it would be exchanged with; `NO_MATCH` beyond. Only the full method knows any.
    """

    recording: Recording
    model: SubjectModel
    trajectories: Trajectories
    identity: Int[np.ndarray, "trajectories"]
    confidence: Float[np.ndarray, "trajectories"]
    reason: tuple[Reason, ...]
    stats: dict[str, Any] = field(default_factory=dict)
    could_be: Int[np.ndarray, "trajectories 2"] | None = None

    def __repr__(self) -> str:
        named = self.identity != NO_MATCH
        found = len(np.unique(self.identity[named]))
        of = f", of {self.recording.source.name}" if self.recording.source else ""
        tracks = f"{int(named.sum())} of {len(self.trajectories)} trajectories named"
        return f"Labelling({tracks}, {found} of {self.model.num_markers} markers found{of})"

    @property
    def identities(self) -> Int[np.ndarray, "frames points"]:
        """The marker of each point of the recording, `NO_MATCH` where unlabelled or not seen."""
        return self.trajectories.by_column(self.identity.astype(np.int32), self.recording.points.shape[1])

    def to_recording(self) -> Recording:
        """The recording with a column for each marker of the model, in its order, then what stayed unlabelled.

        Unlabelled columns are named `*1`, `*2`, ...; no point is lost or moved. Where the labels came from the file's
        own columns no longer shows, so the new recording has no source.
        """
        found, points = self.identities, self.recording.points
        markers = by_marker(points, found, self.model.num_markers)
        rest = np.where((found == NO_MATCH)[..., None], points, np.nan)
        rest = rest[:, np.isfinite(rest).any((0, 2))]
        labels = (*self.model.markers, *(f"*{k + 1}" for k in range(rest.shape[1])))
        return Recording(np.concatenate([markers, rest], axis=1), labels, self.recording.rate, self.recording.unit)

    @property
    def poses(self) -> tuple[Float[np.ndarray, "frames segments 3 3"], Float[np.ndarray, "frames segments 3"]]:
        """Rotation and translation (mm) of every segment's `shape` in every frame.

        Least squares over the markers labelled in that frame; NaN where fewer than three are, or all in a line.
        """
        points = self.to_recording().points
        fits = [rigid_fit(segment.shape, points[:, list(segment.markers)]) for segment in self.model.segments]
        return np.stack([r for r, _ in fits], axis=1), np.stack([t for _, t in fits], axis=1)
