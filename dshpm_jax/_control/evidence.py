"""How well each label fits each trajectory over its whole life, given what is known of the rest of the body."""

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.scene import Scene
from dshpm_jax._model_building import as_arrays
from dshpm_jax._requests import Control, LifeEvidence
from dshpm_jax._types import NO_MATCH

SAMPLE_SECONDS = 0.1
"""A body moves little in this time; a life is judged at frames so far apart."""

ACCEPT = 2.0
"""Nats of mean evidence from which on a label pays: real points that belong to no marker lie near markers more often
than evenly spread ones would."""


def sample_frames(scene: Scene) -> Int[np.ndarray, " frames"]:
    """Evenly spaced frames, and the middle of every trajectory that would fall between them."""
    t = scene.trajectories
    step = max(1, round(SAMPLE_SECONDS * t.rate))
    even = np.arange(step // 2 if t.num_frames > step else 0, t.num_frames, step)
    first = np.searchsorted(even, t.start)
    missed = (first >= len(even)) | (even[np.minimum(first, len(even) - 1)] >= t.stop)
    return np.union1d(even, (t.start[missed] + t.stop[missed] - 1) // 2)


def mean_evidence(scene: Scene, identity: Int[np.ndarray, " trajectories"], frames: np.ndarray) -> Control:
    """Mean evidence for each label over the sampled life of each trajectory, (trajectories, markers) in nats."""
    t = scene.trajectories
    index, points = t.index[frames], t.points[frames]
    named = np.where(index != NO_MATCH, identity[index], NO_MATCH)
    at_frame, at_slot = np.nonzero(named != NO_MATCH)
    identified = np.full((len(frames), scene.model.num_markers, 3), np.nan)
    identified[at_frame, named[at_frame, at_slot]] = points[at_frame, at_slot]
    evidence = yield LifeEvidence(identified, points, *as_arrays(scene.model.neighbourhoods))
    rows = index[index != NO_MATCH]
    total = np.zeros((len(t), scene.model.num_markers))
    order = np.argsort(rows, kind="stable")
    picked = evidence[index != NO_MATCH][order].astype(float)
    firsts = np.flatnonzero(np.r_[True, np.diff(rows[order]) > 0])
    total[rows[order][firsts]] = np.add.reduceat(picked, firsts, axis=0)
    count = np.bincount(rows, minlength=len(t))
    return total / np.maximum(count, 1)[:, None]


def gains(scene: Scene, evidence: np.ndarray) -> Float[np.ndarray, "trajectories markers"]:
    """What a label pays: evidence beyond `ACCEPT`, for as long as the trajectory lives (nat frames)."""
    t = scene.trajectories
    return (evidence - ACCEPT) * (t.stop - t.start)[:, None]


def objective(scene: Scene, identity: np.ndarray, evidence: np.ndarray) -> float:
    """Total gain of the labels given, judged by the evidence that they themselves make; needs no truth."""
    named = np.flatnonzero(identity != NO_MATCH)
    return float(gains(scene, evidence)[named, identity[named]].sum())
