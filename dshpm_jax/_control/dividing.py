"""Trajectories that are two points one after the other: found by what their own frames say, and cut.

Two points that pass each other closely can be exchanged without a leap, in raw tracking as in the columns of a capture
system. Before or after, the trajectory then fits another label than its own, for as long as it lives.
"""

import numpy as np
from jaxtyping import Float

from dshpm_jax._control.evidence import sample_frames
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State, improve, settle
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH

LEAST_FRAMES = 3
"""Sampled frames of the shortest part that is found."""

PART_NATS, FRAME_NATS = 30.0, 5.0
"""Nats by which another label must fit a part better than the trajectory's own, in all and in a frame."""

CLIP = 12.0
"""Nats that a frame counts at most; no single one may decide."""

NEARBY_SECONDS = 0.5
"""Evidence does not tell two points apart that are near each other, so the cut may be so far from where it changes."""

ROUNDS = 3


def divide(scene: Scene, state: State) -> Control:
    """Cuts trajectories where their parts turn out to fit different labels; returns the `Scene` and its `State`."""
    for _ in range(ROUNDS):
        cuts = propose_cuts(scene, state)
        if not cuts:
            break
        tracks, source = scene.trajectories.cut(*map(np.array, zip(*cuts)))
        divided = Scene(tracks, scene.model, scene.settings, scene.body)
        frames = sample_frames(divided)
        after = yield from settle(divided, state.identity[source], frames)
        after = yield from improve(divided, after, frames)
        divided.evidence_fits += scene.evidence_fits
        if (after.identity == state.identity[source]).all():
            break
        scene, state = divided, after
    return scene, state


def propose_cuts(scene: Scene, state: State) -> list[tuple[int, int]]:
    """Trajectories, and the first frame of a later part of each."""
    t, frames = scene.trajectories, sample_frames(scene)
    first, last = np.searchsorted(frames, t.start), np.searchsorted(frames, t.stop)
    cuts = set()
    for j in np.flatnonzero((state.identity != NO_MATCH) & (last - first >= 2 * LEAST_FRAMES)).tolist():
        evidence = state.frames.evidence[first[j] : last[j], t.slot[j]].astype(float)
        for row, label in _changes(evidence, int(state.identity[j])):
            cuts.add((j, _taken_over(scene, state, j, label, int(frames[first[j] + row]))))
    return sorted(cuts)


def _changes(evidence: Float[np.ndarray, "frames markers"], own: int) -> list[tuple[int, int]]:
    """Where the part begins and ends that another label fits better than `own` by the most, and that label."""
    size = len(evidence)
    better = np.clip(evidence - evidence[:, own, None], -CLIP, CLIP)
    total = np.concatenate([np.zeros((1, better.shape[1])), np.cumsum(better, axis=0)])
    since = total - np.minimum.accumulate(total, axis=0)
    end, label = map(int, np.unravel_index(np.argmax(since), since.shape))
    begin = int(np.argmin(total[: end + 1, label]))
    if since[end, label] < max(PART_NATS, FRAME_NATS * (end - begin)) or end - begin < LEAST_FRAMES:
        return []
    return [(row, label) for row in (begin, end) if LEAST_FRAMES <= row <= size - LEAST_FRAMES]


def _taken_over(scene: Scene, state: State, trajectory: int, label: int, frame: int) -> int:
    """The frame around `frame` from which on the trajectory and one that carries `label` had best be each other's
    continuation; the same for both. `frame` itself where there is no such trajectory."""
    t = scene.trajectories
    reach = round(NEARBY_SECONDS * t.rate)
    around = np.arange(max(t.start[trajectory] + 1, frame - reach), min(t.stop[trajectory], frame + reach + 1))
    others = np.flatnonzero((state.identity == label) & (t.start <= around[-1]) & (around[0] < t.stop))
    own, other = (t.positions(np.append(around[0] - 1, around), which) for which in (np.array([trajectory]), others))
    longer = _step(own, other) - _step(own, own)
    longer += np.nan_to_num(_step(other, own) - _step(other, other))  # the other may begin here
    longer = np.where(np.isfinite(longer), longer, np.inf).min(1, initial=np.inf)
    return int(around[np.argmin(longer)]) if np.isfinite(longer).any() else frame


def _step(before: np.ndarray, after: np.ndarray) -> Float[np.ndarray, "frames trajectories"]:
    """How far it is from each frame's points to the next frame's (mm)."""
    return np.linalg.norm(after[1:] - before[:-1], axis=-1)
