"""What a labelling of the whole recording is worth; it needs no truth."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.full.evidence import FrameEvidence, mean_over_lives
from dshpm_jax._control.full.whole_body import whole_body_gain
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True, eq=False)
class Solution:
    """A labelling of the whole recording and what it is worth.

    Attributes:
        identity: the marker of each trajectory, `NO_MATCH` where unknown.
        llr: mean log-likelihood ratio of each label for each trajectory, given `identity` (nats); `CLOSED_LLR` for
            labels that it cannot get.
        objective: what the labelling is worth (nat frames); larger is better.
        evidence: the evidence in the sampled frames.
        divided: whether the key-frames that led to it were at odds, see `Votes.divided`.
    """

    identity: Int[np.ndarray, " trajectories"]
    llr: Float[np.ndarray, "trajectories markers"]
    objective: float
    evidence: FrameEvidence
    divided: bool = False

    @classmethod
    def of(cls, problem: LabellingProblem, identity: np.ndarray, evidence: FrameEvidence) -> "Solution":
        """The solution with these labels, judged by the evidence that they make."""
        llr = problem.fixed.llr(mean_over_lives(problem, evidence))
        return cls(identity, llr, objective(problem, identity, llr, evidence), evidence)


@dataclass
class Incumbent:
    """The best solution so far; it owns the evidence, which is large in a long recording.

    Nothing else keeps a solution while a stage runs, so that the evidence of one that is beaten is freed.
    """

    solution: Solution

    @property
    def objective(self) -> float:
        return self.solution.objective

    def offer(self, problem: LabellingProblem, other: Solution | None) -> bool:
        """Takes the other solution's place if that is worth more; whether it does.

        Here the whole body is asked too: by how much the mean distances prefer the other.
        """
        if other is None:
            return False
        whole = whole_body_gain(problem, self.solution.identity, other.identity) * problem.trajectories.num_frames
        if other.objective + whole <= self.solution.objective:
            return False
        self.solution = other
        return True


def better_of(one: Solution, other: Solution) -> Solution:
    """The solution that is worth more, the first of equals."""
    return other if other.objective > one.objective else one


def gains(problem: LabellingProblem, llr: np.ndarray) -> Float[np.ndarray, "trajectories markers"]:
    """What a label pays: mean evidence beyond `Tuning.accept_llr`, for as long as the trajectory lives (nat frames)."""
    t = problem.trajectories
    return (llr - problem.tuning.accept_llr) * (t.stop - t.start)[:, None]


def objective(problem: LabellingProblem, identity: np.ndarray, llr: np.ndarray, evidence: FrameEvidence) -> float:
    """What a labelling is worth (nat frames), judged by the evidence that it makes itself.

    The gains of its labels, and how well the distances between all its markers fit the model: a head turned back to
    front predicts itself perfectly, and only its distances to the trunk tell.
    """
    given = np.flatnonzero(identity != NO_MATCH)
    own = float(gains(problem, llr)[given, identity[given]].sum())
    return own + float(evidence.distance_llr.mean()) * problem.trajectories.num_frames


def gain_in_frames(problem: LabellingProblem, evidence: FrameEvidence) -> Float[np.ndarray, "frames markers"]:
    """What the label of each marker pays in each sampled frame (nats), 0 where none has it."""
    gain = np.zeros((len(evidence.labels), problem.model.num_markers))
    frame, slot = np.nonzero(evidence.labels != NO_MATCH)
    label = evidence.labels[frame, slot]
    gain[frame, label] = evidence.llr[frame, slot, label] - problem.tuning.accept_llr
    return gain


def share_held(problem: LabellingProblem, solution: Solution) -> float:
    """The evidence that the labels hold, against right ones of which every marker is seen in every frame."""
    gain = np.maximum(gain_in_frames(problem, solution.evidence), 0.0)
    return float(gain.mean(0).sum() / problem.prepared.usual_gain.sum())


def model_fit(problem: LabellingProblem, solution: Solution) -> float:
    """The evidence that the labels hold against what right ones usually do: about 1 where the model is the subject's.

    Markers without a point count for nothing; where more than half of them are missing, what is left still holds less,
    as it has fewer neighbours. 0 without any label.
    """
    gain = np.maximum(gain_in_frames(problem, solution.evidence), 0.0)
    given = solution.evidence.labels[solution.evidence.labels != NO_MATCH]
    return float(gain.sum() / problem.prepared.usual_gain[given].sum()) if len(given) else 0.0
