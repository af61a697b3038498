"""The first labels of a recording: what many key-frames say, each identified for itself."""

import math
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.assignment import assign_labels
from dshpm_jax._control.dynamic import identify
from dshpm_jax._control.scene import Known, Scene
from dshpm_jax._requests import Control, Together
from dshpm_jax._types import NO_MATCH

DENSER = (1, 3)
"""Key-frames are asked in two sets, the second so many times as dense; it is asked only where the first is at odds."""

AGREED, FOUND = 0.95, 0.9
"""The first set will do if so many of its votes go to the label that wins, and so many segments were found."""

DIVIDED = 0.5
"""Votes are divided where fewer of them go to the label that wins."""

KEY_SECONDS = 20.0
"""From a key-frame labels spread over some lives of trajectories and no farther, so long recordings need more."""


@dataclass(eq=False)
class Votes:
    """What the key-frames said that were asked so far.

    Attributes:
        count: how many of them gave each label to each trajectory.
        identity: the labels with the most votes.
        frames: which they were.
        parts: what each found.
    """

    count: Float[np.ndarray, "trajectories markers"]
    identity: Int[np.ndarray, " trajectories"]
    frames: list[int] = field(default_factory=list)
    parts: list[Known] = field(default_factory=list)

    @classmethod
    def none(cls, scene: Scene) -> "Votes":
        size = len(scene.trajectories)
        return cls(np.zeros((size, scene.model.num_markers)), np.full(size, NO_MATCH, np.int32))

    @property
    def fits(self) -> int:
        """Rigid fits that they took."""
        return sum(part.fits for part in self.parts)

    @property
    def agreement(self) -> float:
        """The share of the votes that went to the label which their trajectory got."""
        named = np.flatnonzero(self.identity != NO_MATCH)
        return float(self.count[named, self.identity[named]].sum() / max(self.count.sum(), 1.0))

    @property
    def suffice(self) -> bool:
        """Whether nearly all votes went to one label, and nearly all segments were found."""
        return self.agreement >= AGREED and bool(np.mean([part.found for part in self.parts]) >= FOUND)

    @property
    def divided(self) -> bool:
        """Whether there are votes, and most of them went to other labels than those that won."""
        return bool(self.count.any()) and self.agreement < DIVIDED

    def ask(self, scene: Scene, factor: float) -> Control:
        """Asks `factor` times the usual number of key-frames, less those that were asked before."""
        wanted = key_frames(scene, max(1, round(factor * usual_number(scene))))
        frames = [frame for frame in wanted if frame not in self.frames]
        parts: list[Known] = yield Together(tuple(identify(scene, frame) for frame in frames))
        self.frames += frames
        self.parts += parts
        for part in parts:
            named = np.flatnonzero(part.identity != NO_MATCH)
            self.count[named, part.identity[named]] += 1
        self.identity = assign_labels(self.count, scene.trajectories.start, scene.trajectories.stop)


def usual_number(scene: Scene) -> int:
    """Key-frames as in the settings, or more where these would be more than `KEY_SECONDS` apart."""
    seconds = scene.trajectories.num_frames / scene.trajectories.rate
    return max(scene.settings.num_key_frames, math.ceil(seconds / KEY_SECONDS))


def vote(scene: Scene) -> Control:
    """Labels by the votes of key-frames."""
    votes = Votes.none(scene)
    for factor in DENSER:
        yield from votes.ask(scene, factor)
        if votes.suffice:
            break
    return votes.identity


def key_frames(scene: Scene, count: int) -> list[int]:
    """Frames spread evenly over the recording, each the fullest of its share."""
    seen = (scene.trajectories.index != NO_MATCH).sum(1)
    seen = np.minimum(seen, scene.model.num_markers)
    edges = np.linspace(0, len(seen), min(count, len(seen)) + 1).astype(int)
    frames = []
    for first, last in zip(edges[:-1], edges[1:]):
        part = seen[first:last]
        best = np.flatnonzero(part == part.max())
        frames.append(int(first + best[np.argmin(np.abs(best - len(part) / 2))]))
    return frames
