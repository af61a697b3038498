"""Trajectories judged by their whole life, against the places that the rest of the body predicts."""

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.assignment import assign_labels
from dshpm_jax._control.dynamic import identify
from dshpm_jax._control.scene import Known, Scene
from dshpm_jax._model_building import as_arrays
from dshpm_jax._requests import Control, LifeEvidence, Together
from dshpm_jax._types import NO_MATCH

MAX_ROUNDS = 8
ACCEPT = 2.0  # nats of mean evidence from which on a label pays
MARGINS = (6.0, 4.0, 2.0, 0.0)  # nats
SAMPLE_SECONDS = 0.1


def full(scene: Scene) -> Control:
    """Evidence from many key-frames, then one assignment for the whole recording, repeated until it stands."""
    parts = yield Together(tuple(identify(scene, frame) for frame in key_frames(scene)))
    known = Known.nothing(scene)
    known.fits = sum(part.fits for part in parts)
    t = scene.trajectories
    known.identity = assign_labels(_votes(scene, parts), t.start, t.stop)
    frames = sample_frames(scene)
    known.identity = yield from settle(scene, known.identity, frames)
    return known


def settle(scene: Scene, identity: np.ndarray, frames: np.ndarray) -> Control:
    """Judges and assigns in turn until nothing changes, the most certain labels first."""
    for margin in MARGINS:
        seen: list[np.ndarray] = []
        while len(seen) < MAX_ROUNDS and not any((identity == earlier).all() for earlier in seen):
            seen.append(identity)
            evidence = yield from mean_evidence(scene, identity, frames)
            identity = assign_certain(scene, evidence, margin)
    return identity


def assign_certain(scene: Scene, evidence: np.ndarray, margin: float) -> np.ndarray:
    """The best assignment, less what a rival comes within `margin` nats of: another label, or another trajectory
    for the label while this one lives."""
    t = scene.trajectories
    identity = assign_labels((evidence - ACCEPT) * (t.stop - t.start)[:, None], t.start, t.stop)
    if margin <= 0:
        return identity
    named = np.flatnonzero(identity != NO_MATCH)
    own = evidence[named, identity[named]]
    others = evidence[named].copy()
    others[np.arange(len(named)), identity[named]] = -np.inf
    rival = others.max(1)
    overlap = (t.start[named, None] < t.stop[None]) & (t.start[None] < t.stop[named, None])
    overlap[np.arange(len(named)), named] = False
    rival = np.maximum(rival, np.where(overlap, evidence[:, identity[named]].T, -np.inf).max(1))
    identity = identity.copy()
    identity[named[own - rival < margin]] = NO_MATCH
    return identity


def key_frames(scene: Scene) -> list[int]:
    """Frames spread evenly over the recording, each the fullest of its share."""
    seen = (scene.trajectories.index != NO_MATCH).sum(1)
    seen = np.minimum(seen, scene.model.num_markers)
    edges = np.linspace(0, len(seen), min(scene.settings.num_key_frames, len(seen)) + 1).astype(int)
    frames = []
    for first, last in zip(edges[:-1], edges[1:]):
        part = seen[first:last]
        best = np.flatnonzero(part == part.max())
        frames.append(int(first + best[np.argmin(np.abs(best - len(part) / 2))]))
    return frames


def _votes(scene: Scene, parts: list[Known]) -> Float[np.ndarray, "trajectories markers"]:
    votes = np.zeros((len(scene.trajectories), scene.model.num_markers))
    for part in parts:
        named = np.flatnonzero(part.identity != NO_MATCH)
        votes[named, part.identity[named]] += 1
    return votes


def sample_frames(scene: Scene) -> Int[np.ndarray, " frames"]:
    """Evenly spaced frames, and the middle of every trajectory that would fall between them."""
    t = scene.trajectories
    step = max(1, round(SAMPLE_SECONDS * t.rate))
    even = np.arange(step // 2 if t.num_frames > step else 0, t.num_frames, step)
    first = np.searchsorted(even, t.start)
    missed = (first >= len(even)) | (even[np.minimum(first, len(even) - 1)] >= t.stop)
    return np.union1d(even, (t.start[missed] + t.stop[missed] - 1) // 2)


def mean_evidence(scene: Scene, identity: np.ndarray, frames: np.ndarray) -> Control:
    """Mean cost of each label over the sampled life of each trajectory."""
    t = scene.trajectories
    index, points = t.index[frames], t.points[frames]
    named = np.where(index != NO_MATCH, identity[index], NO_MATCH)
    at_frame, at_slot = np.nonzero(named != NO_MATCH)
    identified = np.full((len(frames), scene.model.num_markers, 3), np.nan)
    identified[at_frame, named[at_frame, at_slot]] = points[at_frame, at_slot]
    cost = yield LifeEvidence(identified, points, *as_arrays(scene.model.neighbourhoods))
    rows = index[index != NO_MATCH]
    total = np.zeros((len(t), scene.model.num_markers))
    order = np.argsort(rows, kind="stable")
    picked = cost[index != NO_MATCH][order].astype(float)
    firsts = np.flatnonzero(np.r_[True, np.diff(rows[order]) > 0])
    total[rows[order][firsts]] = np.add.reduceat(picked, firsts, axis=0)
    count = np.bincount(rows, minlength=len(t))
    return total / np.maximum(count, 1)[:, None]
