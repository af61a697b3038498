"""Labels found so far: which trajectory is which marker, and which segments are identified."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._requests import Target
from dshpm_jax._types import NO_MATCH


@dataclass(eq=False)
class PartialLabels:
    """Identities found so far.

    Attributes:
        identity: the marker of each trajectory, `NO_MATCH` where unknown.
        found: which segments are identified.
        recruited: which trajectories got their identity from a predicted place, not from a match.
        given: whose identity is given, and stays.
    """

    identity: Int[np.ndarray, " trajectories"]
    found: Bool[np.ndarray, " segments"]
    recruited: Bool[np.ndarray, " trajectories"]
    given: Bool[np.ndarray, " trajectories"]

    @classmethod
    def nothing(cls, problem: LabellingProblem) -> "PartialLabels":
        """No labels but those that are given."""
        return cls.of(problem, np.full(len(problem.trajectories), NO_MATCH, dtype=np.int32))

    @classmethod
    def of(
        cls, problem: LabellingProblem, identity: Int[np.ndarray, " trajectories"], found: bool = False
    ) -> "PartialLabels":
        """These identities around those that are given, with all segments or none of them taken for identified."""
        segments, recruited = np.full(len(problem.model.segments), found), np.zeros(len(identity), bool)
        return cls(problem.fixed.on(identity.copy()), segments, recruited, problem.fixed.given)

    def copy(self) -> "PartialLabels":
        return PartialLabels(self.identity.copy(), self.found.copy(), self.recruited.copy(), self.given)

    def restore(self, earlier: "PartialLabels") -> None:
        """Back to `earlier`."""
        self.identity[:], self.found[:], self.recruited[:] = earlier.identity, earlier.found, earlier.recruited

    def forget(self, which: Bool[np.ndarray, " trajectories"]) -> None:
        """Takes the identities of some trajectories away."""
        self.identity[which & ~self.given] = NO_MATCH

    def unclaimed(self, which: Int[np.ndarray, " some"]) -> Bool[np.ndarray, " some"]:
        """Which of some trajectories may still become any marker."""
        return (self.identity[which] == NO_MATCH) & ~self.given[which]

    def recruit(self, trajectory: int, marker: int) -> None:
        """Gives a trajectory the identity of the marker near whose predicted place it is."""
        self.identity[trajectory], self.recruited[trajectory] = marker, True

    def trajectory_of_marker(self, problem: LabellingProblem, frame: int) -> Int[np.ndarray, " markers"]:
        """The trajectory that carries each marker of the model in `frame`, or `NO_MATCH`."""
        here, _ = problem.at(frame)
        found = np.full(problem.model.num_markers, NO_MATCH)
        named = here[self.identity[here] != NO_MATCH]
        found[self.identity[named]] = named
        return found

    def trajectories_of(
        self, problem: LabellingProblem, markers: Int[np.ndarray, " markers"], frame: int
    ) -> Int[np.ndarray, " markers"]:
        """The trajectory that carries each of `markers` in `frame`, or `NO_MATCH`."""
        return np.where(markers != NO_MATCH, self.trajectory_of_marker(problem, frame)[markers], NO_MATCH)

    def clashes(self, problem: LabellingProblem, trajectory: int, marker: int) -> Bool[np.ndarray, " trajectories"]:
        """Trajectories that carry `marker` during the life of `trajectory`."""
        t = problem.trajectories
        same = (self.identity == marker) & (t.start < t.stop[trajectory]) & (t.start[trajectory] < t.stop)
        same[trajectory] = False
        return same

    def places(
        self, problem: LabellingProblem, target: Target, frame: int
    ) -> tuple[Float[np.ndarray, "columns 3"], Bool[np.ndarray, " columns"]]:
        """Where the identified markers of `target` are in `frame` (mm), NaN for the others, and which are there."""
        carrying = self.trajectories_of(problem, target.markers, frame)
        points = problem.trajectories.positions(np.array([frame]), carrying)[0]
        return points, carrying != NO_MATCH
