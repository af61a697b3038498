"""The first labels of a recording: what many key-frames say, each identified for itself."""

import math
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.full.assignment import assign
from dshpm_jax._control.paper.dynamic import identify
from dshpm_jax._control.partial_labels import PartialLabels
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._requests import Control, Gather
from dshpm_jax._types import NO_MATCH


@dataclass(eq=False)
class Votes:
    """What the key-frames said that were asked so far.

    Attributes:
        count: how many of them gave each label to each trajectory.
        identity: the labels with the most votes.
        frames: which they were.
        parts: what each found.
    """

    problem: LabellingProblem
    count: Float[np.ndarray, "trajectories markers"]
    identity: Int[np.ndarray, " trajectories"]
    frames: list[int] = field(default_factory=list)
    parts: list[PartialLabels] = field(default_factory=list)

    @classmethod
    def none(cls, problem: LabellingProblem) -> "Votes":
        size = len(problem.trajectories)
        return cls(problem, np.zeros((size, problem.model.num_markers)), np.full(size, NO_MATCH, np.int32))

    @property
    def agreement(self) -> float:
        """The share of the votes that went to the label which their trajectory got."""
        named = np.flatnonzero(self.identity != NO_MATCH)
        return float(self.count[named, self.identity[named]].sum() / max(self.count.sum(), 1.0))

    @property
    def agree(self) -> bool:
        """Whether nearly all votes went to one label."""
        return self.agreement >= self.problem.tuning.min_vote_agreement

    @property
    def suffice(self) -> bool:
        """Whether they agree, and nearly all segments were found."""
        found = np.mean([part.found for part in self.parts])
        return self.agree and bool(found >= self.problem.tuning.min_segments_found)

    @property
    def divided(self) -> bool:
        """Whether there are votes, and most of them went to other labels than those that won."""
        return bool(self.count.any()) and self.agreement < self.problem.tuning.divided_below

    def ask(self, factor: float) -> Control[None]:
        """Asks `factor` times the usual number of key-frames, less those that were asked before."""
        wanted = key_frames(self.problem, max(1, round(factor * usual_number(self.problem))))
        frames = [frame for frame in wanted if frame not in self.frames]
        parts: list[PartialLabels] = yield Gather(tuple(identify(self.problem, frame) for frame in frames))
        self.frames += frames
        self.parts += parts
        for part in parts:
            named = np.flatnonzero(part.identity != NO_MATCH)
            self.count[named, part.identity[named]] += 1
        self.identity = assign(self.problem, self.count)


def usual_number(problem: LabellingProblem) -> int:
    """Key-frames as in the settings, or more where these would be more than `Tuning.key_frame_seconds` apart."""
    seconds = problem.trajectories.num_frames / problem.trajectories.rate
    return max(problem.settings.num_key_frames, math.ceil(seconds / problem.tuning.key_frame_seconds))


def vote(problem: LabellingProblem) -> Control[Int[np.ndarray, " trajectories"]]:
    """Labels by the votes of key-frames."""
    votes = Votes.none(problem)
    for factor in problem.tuning.key_frame_factors:
        yield from votes.ask(factor)
        if votes.suffice:
            break
    return votes.identity


def key_frames(problem: LabellingProblem, count: int) -> list[int]:
    """Frames spread evenly over the recording, each the fullest of its share."""
    seen = (problem.trajectories.index != NO_MATCH).sum(1)
    seen = np.minimum(seen, problem.model.num_markers)
    edges = np.linspace(0, len(seen), min(count, len(seen)) + 1).astype(int)
    frames = []
    for first, last in zip(edges[:-1], edges[1:]):
        part = seen[first:last]
        best = np.flatnonzero(part == part.max())
        frames.append(int(first + best[np.argmin(np.abs(best - len(part) / 2))]))
    return frames
