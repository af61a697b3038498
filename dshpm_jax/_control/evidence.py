"""How well each label fits each trajectory over its whole life, given what is known of the rest of the body."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import csr_array

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

FRAMES_AT_ONCE = 1024  # whose evidence is summed, or whose distances are held, together


def sample_frames(scene: Scene) -> Int[np.ndarray, " frames"]:
    """Evenly spaced frames, and as few more as it takes to see every trajectory at least once."""
    t = scene.trajectories
    step = max(1, round(SAMPLE_SECONDS * t.rate), -(-t.num_frames // MAX_SAMPLES))
    even = np.arange(step // 2 if t.num_frames > step else 0, t.num_frames, step)
    return _with_all_seen(scene, even, np.arange(t.num_frames))


def fewer_frames(scene: Scene, frames: Int[np.ndarray, " frames"], step: int) -> Int[np.ndarray, " fewer"]:
    """Every `step`-th of the frames, and as few more of them as it takes to see every trajectory that they show."""
    return _with_all_seen(scene, frames[min(step, len(frames)) // 2 :: step], frames)


def _with_all_seen(scene: Scene, frames: np.ndarray, others: np.ndarray) -> np.ndarray:
    """The frames, and as few of the others as it takes to see every trajectory."""
    t = scene.trajectories
    first = np.searchsorted(frames, t.start)
    missed = np.flatnonzero((first >= len(frames)) | (frames[np.minimum(first, len(frames) - 1)] >= t.stop))
    more, last = [], -1
    for j in missed[np.argsort(t.stop[missed], kind="stable")]:  # by their ends: each frame stabs as many as it can
        if t.start[j] > last:
            last = int(others[np.searchsorted(others, t.stop[j]) - 1])
            more.append(last)
    return np.union1d(frames, np.array(more, dtype=frames.dtype))


@dataclass(frozen=True, eq=False)
class FrameEvidence:
    """Evidence in the sampled frames, kept so that only what a change of labels touches is judged anew.

    Attributes:
        named: the label of each slot, `NO_MATCH` where there is none.
        evidence: for each point of the frames and each label (nats).
        posture: see `posture`.
    """

    named: Int[np.ndarray, "frames slots"]
    evidence: Float[np.ndarray, "frames slots markers"]
    posture: Float[np.ndarray, " frames"]

    def rows(self, rows: Int[np.ndarray, " rows"]) -> "FrameEvidence":
        """Some of the frames, which may repeat."""
        return FrameEvidence(self.named[rows], self.evidence[rows], self.posture[rows])


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
    holder = holders(named, markers)
    if before is None:
        evidence, fit = np.empty((*named.shape, markers), np.float32), np.empty(len(frames))
        moved = np.ones((len(frames), markers), bool)
        stale = moved
    else:
        evidence, fit = before.evidence.copy(), before.posture.copy()
        moved = holder != holders(before.named, markers)
        stale = of_neighbours(scene, moved).any(-1)
    changed = np.flatnonzero(moved.any(1))
    if len(changed):
        points = scene.trajectories.points[frames]
        places = np.take_along_axis(points, np.maximum(holder, 0)[..., None], axis=1)
        identified = np.where((holder != NO_MATCH)[..., None], places, np.nan)
        fit[changed] = posture(scene, identified[changed])
        frame, marker = np.nonzero(stale)
        scene.evidence_fits += FITS_PER_PLACE * len(frame)
        evidence[frame, :, marker] = yield LifeEvidence(identified, points, frame, marker, *scene.body.neighbourhoods)
    return FrameEvidence(named, evidence, fit)


def holders(named: Int[np.ndarray, "frames slots"], markers: int) -> Int[np.ndarray, "frames markers"]:
    """The slot that carries each marker, `NO_MATCH` where none does."""
    holder = np.full((len(named), markers), NO_MATCH)
    frame, slot = np.nonzero(named != NO_MATCH)
    holder[frame, named[frame, slot]] = slot
    return holder


def of_neighbours(
    scene: Scene, flags: Bool[np.ndarray, "frames markers"]
) -> Bool[np.ndarray, "frames markers neighbours"]:
    """The flags of the neighbours of each marker, False beyond its last one."""
    around = scene.body.neighbourhoods[0]
    return flags[:, np.maximum(around, 0)] & (around != NO_MATCH)


def mean_over_lives(
    scene: Scene, frames: np.ndarray, found: FrameEvidence
) -> Float[np.ndarray, "trajectories markers"]:
    """Mean evidence for each label over the sampled life of each trajectory (nats)."""
    index = scene.trajectories.index[frames]
    shape = len(scene.trajectories), scene.model.num_markers
    total, count = np.zeros(shape), np.bincount(index[index != NO_MATCH], minlength=shape[0])
    for first in range(0, len(frames), FRAMES_AT_ONCE):
        some = index[first : first + FRAMES_AT_ONCE].ravel()
        point = np.flatnonzero(some != NO_MATCH)
        sums = csr_array((np.ones(len(point)), (some[point], point)), shape=(shape[0], len(some)))
        total += sums @ found.evidence[first : first + FRAMES_AT_ONCE].reshape(-1, shape[1])
    return total / np.maximum(count, 1)[:, None]


def gains(scene: Scene, evidence: np.ndarray) -> Float[np.ndarray, "trajectories markers"]:
    """What a label pays: evidence beyond `ACCEPT`, for as long as the trajectory lives (nat frames)."""
    t = scene.trajectories
    return (evidence - ACCEPT) * (t.stop - t.start)[:, None]


def objective(scene: Scene, identity: np.ndarray, evidence: np.ndarray, found: FrameEvidence) -> float:
    """What a labelling is worth (nat frames), judged by the evidence that it makes itself; needs no truth.

    The gains of its labels, and how well the distances between all its markers fit the model: a head turned back to
    front predicts itself perfectly, and only its distances to the trunk tell.
    """
    given = np.flatnonzero(identity != NO_MATCH)
    own = float(gains(scene, evidence)[given, identity[given]].sum())
    return own + float(found.posture.mean()) * scene.trajectories.num_frames


def posture(scene: Scene, places: Float[np.ndarray, "frames markers 3"]) -> Float[np.ndarray, " frames"]:
    """Evidence in the distances between all identified markers of each frame (nats); NaN places are not identified.

    A marker has as many distances as there are others, most of them saying the same; together they count as
    `POSTURE_PAIRS`. A distance that does not fit says nothing: bodies take postures that no model has seen.
    """
    parts = [places[first : first + FRAMES_AT_ONCE] for first in range(0, len(places), FRAMES_AT_ONCE)]
    subjects = scene.body.subjects
    total = [sum((_posture(part[:, own], *pairs) for own, *pairs in subjects), np.zeros(len(part))) for part in parts]
    return np.concatenate([np.zeros(0), *total]) * (0.5 * POSTURE_PAIRS / scene.body.partners)


def _posture(
    places: np.ndarray, mean: np.ndarray, inverse: np.ndarray, peak: np.ndarray
) -> Float[np.ndarray, " frames"]:
    """The evidence in all distances of a subject, in frames whose tables of them fit into memory together.

    Arguments:
        places: (frames, markers, 3), mm.
        mean, inverse, peak: `Body.pairs` of the subject.
    """
    there = np.asarray(np.isfinite(places[..., 0])).astype(np.float32)
    places = np.nan_to_num(places)
    middle = np.einsum("fmi,fm->fi", places, there) / np.maximum(there.sum(1), 1.0)[:, None]
    places = ((places - middle[:, None]) * there[..., None]).astype(np.float32)
    square = (places**2).sum(-1)
    error = square[:, :, None] + square[:, None] - 2.0 * places @ places.transpose(0, 2, 1)
    np.sqrt(np.maximum(error, 0.0, out=error), out=error)
    error -= mean
    error *= inverse
    error *= error
    error += 1.0
    np.log(error, out=error)
    error *= -2.0
    error += peak
    np.maximum(error, 0.0, out=error)
    return ((error @ there[..., None])[..., 0] * there).sum(-1)
