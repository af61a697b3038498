"""How well each label fits each trajectory over its whole life, given what is known of the rest of the body."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.scene import Scene
from dshpm_jax._requests import Control, LifeEvidence
from dshpm_jax._types import NO_MATCH

SAMPLE_SECONDS, MAX_SAMPLES = 0.1, 100
"""A body moves little in this time; a life is judged at frames so far apart, or at so many."""

ACCEPT = 2.0
"""Nats of mean evidence from which on a label pays: real points that belong to no marker lie near markers more often
than evenly spread ones would."""

FITS_PER_PLACE = 3  # reweighted fits behind each predicted place

POSTURE_PAIRS = 4.0
POSTURE_RANGE = 700.0
"""Of so many millimetres a distance would be anything if the labels meant nothing."""


def sample_frames(scene: Scene) -> Int[np.ndarray, " frames"]:
    """Evenly spaced frames, and as few more as it takes to see every trajectory at least once."""
    t = scene.trajectories
    step = max(1, round(SAMPLE_SECONDS * t.rate), -(-t.num_frames // MAX_SAMPLES))
    even = np.arange(step // 2 if t.num_frames > step else 0, t.num_frames, step)
    first = np.searchsorted(even, t.start)
    missed = np.flatnonzero((first >= len(even)) | (even[np.minimum(first, len(even) - 1)] >= t.stop))
    more, last = [], -1
    for j in missed[np.argsort(t.stop[missed], kind="stable")]:  # by their ends: each frame stabs as many as it can
        if t.start[j] > last:
            last = int(t.stop[j]) - 1
            more.append(last)
    return np.union1d(even, np.array(more, dtype=even.dtype))


@dataclass(frozen=True, eq=False)
class FrameEvidence:
    """Evidence in the sampled frames, kept so that only what a change of labels touches is judged anew.

    Attributes:
        named: the label of each slot, `NO_MATCH` where there is none.
        evidence: for each point of the frames and each label (nats).
    """

    named: Int[np.ndarray, "frames slots"]
    evidence: Float[np.ndarray, "frames slots markers"]


def labels_in(scene: Scene, identity: np.ndarray, frames: np.ndarray) -> Int[np.ndarray, "frames slots"]:
    """The label of every slot in `frames`."""
    index = scene.trajectories.index[frames]
    return np.where(index != NO_MATCH, identity[np.maximum(index, 0)], NO_MATCH)


def frame_evidence(
    scene: Scene, frames: np.ndarray, named: Int[np.ndarray, "frames slots"], before: FrameEvidence | None = None
) -> Control:
    """Evidence in `frames` given the labels `named` in them.

    Of what is known from `before`, only markers with a neighbour that is elsewhere now are judged anew.
    """
    markers = scene.model.num_markers
    around = scene.neighbourhoods[0]
    holder = _holders(named, markers)
    if before is None:
        evidence = np.empty((*named.shape, markers), np.float32)
        stale = np.ones((len(frames), markers), bool)
    else:
        evidence = before.evidence.copy()
        moved = holder != _holders(before.named, markers)
        stale = (moved[:, np.maximum(around, 0)] & (around != NO_MATCH)).any(-1)
    frame, marker = np.nonzero(stale)
    if len(frame):
        points = scene.trajectories.points[frames]
        places = np.take_along_axis(points, np.maximum(holder, 0)[..., None], axis=1)
        identified = np.where((holder != NO_MATCH)[..., None], places, np.nan)
        scene.evidence_fits += FITS_PER_PLACE * len(frame)
        evidence[frame, :, marker] = yield LifeEvidence(identified, points, frame, marker, *scene.neighbourhoods)
    return FrameEvidence(named, evidence)


def _holders(named: Int[np.ndarray, "frames slots"], markers: int) -> Int[np.ndarray, "frames markers"]:
    """The slot that carries each marker, `NO_MATCH` where none does."""
    holder = np.full((len(named), markers), NO_MATCH)
    frame, slot = np.nonzero(named != NO_MATCH)
    holder[frame, named[frame, slot]] = slot
    return holder


def mean_over_lives(
    scene: Scene, frames: np.ndarray, found: FrameEvidence
) -> Float[np.ndarray, "trajectories markers"]:
    """Mean evidence for each label over the sampled life of each trajectory (nats)."""
    t = scene.trajectories
    index = t.index[frames]
    rows = index[index != NO_MATCH]
    total = np.zeros((len(t), scene.model.num_markers))
    order = np.argsort(rows, kind="stable")
    picked = found.evidence[index != NO_MATCH][order].astype(float)
    firsts = np.flatnonzero(np.r_[True, np.diff(rows[order]) > 0])
    total[rows[order][firsts]] = np.add.reduceat(picked, firsts, axis=0)
    count = np.bincount(rows, minlength=len(t))
    return total / np.maximum(count, 1)[:, None]


def gains(scene: Scene, evidence: np.ndarray) -> Float[np.ndarray, "trajectories markers"]:
    """What a label pays: evidence beyond `ACCEPT`, for as long as the trajectory lives (nat frames)."""
    t = scene.trajectories
    return (evidence - ACCEPT) * (t.stop - t.start)[:, None]


def objective(scene: Scene, identity: np.ndarray, evidence: np.ndarray, frames: np.ndarray, named: np.ndarray) -> float:
    """What a labelling is worth (nat frames), judged by the evidence that it makes itself; needs no truth.

    The gains of its labels, and how well the distances between all its markers fit the model: a head turned back to
    front predicts itself perfectly, and only its distances to the trunk tell.
    """
    given = np.flatnonzero(identity != NO_MATCH)
    own = float(gains(scene, evidence)[given, identity[given]].sum())
    return own + float(posture(scene, frames, named).mean()) * scene.trajectories.num_frames


def posture(scene: Scene, frames: np.ndarray, named: Int[np.ndarray, "frames slots"]) -> Float[np.ndarray, " frames"]:
    """Evidence in the distances between all markers named in each frame (nats).

    A marker has as many distances as there are others, most of them saying the same; together they count as
    `POSTURE_PAIRS`.
    """
    markers = scene.model.num_markers
    places = np.full((len(frames), markers, 3), np.nan, np.float32)
    at_frame, at_slot = np.nonzero(named != NO_MATCH)
    places[at_frame, named[at_frame, at_slot]] = scene.trajectories.points[frames[at_frame], at_slot]
    one, other, mean, deviation = scene.pairs
    distance = np.linalg.norm(places[:, one] - places[:, other], axis=-1)
    square = ((distance - mean) / deviation) ** 2
    ratio = np.log(POSTURE_RANGE / deviation) - 2.0 * np.log1p(square / 3.0)
    return np.nansum(ratio, axis=1) * POSTURE_PAIRS / markers
