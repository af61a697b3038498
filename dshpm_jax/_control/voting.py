"""The first labels of a recording: what many key-frames say, each identified for itself."""

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


def vote(scene: Scene) -> Control:
    """Labels by the votes of key-frames, and the rigid fits that these took."""
    t = scene.trajectories
    votes = np.zeros((len(t), scene.model.num_markers))
    asked: list[int] = []
    found: list[Known] = []
    identity = np.full(len(t), NO_MATCH, np.int32)
    for factor in DENSER:
        frames = [f for f in key_frames(scene, factor * scene.settings.num_key_frames) if f not in asked]
        asked += frames
        parts: list[Known] = yield Together(tuple(identify(scene, frame) for frame in frames))
        found += parts
        for part in parts:
            named = np.flatnonzero(part.identity != NO_MATCH)
            votes[named, part.identity[named]] += 1
        identity = assign_labels(votes, t.start, t.stop)
        if _agreement(votes, identity) >= AGREED and np.mean([part.found for part in found]) >= FOUND:
            break
    return identity, sum(part.fits for part in found)


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


def _agreement(votes: Float[np.ndarray, "trajectories markers"], identity: Int[np.ndarray, " trajectories"]) -> float:
    """The share of the votes that went to the label which their trajectory got."""
    named = np.flatnonzero(identity != NO_MATCH)
    return float(votes[named, identity[named]].sum() / max(votes.sum(), 1.0))
