"""How well each label fits each point of the sampled frames, and each trajectory over its life."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import csr_array

from dshpm_jax._control.full.distances import distance_llr
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._requests import Control, LifeEvidence
from dshpm_jax._trajectories import by_marker
from dshpm_jax._types import NO_MATCH

FRAMES_AT_ONCE = 1024  # whose evidence is summed together; more need more memory


@dataclass(frozen=True, eq=False)
class FrameEvidence:
    """Evidence in the sampled frames, kept so that only what a change of labels touches is judged anew.

    Attributes:
        frames: which they are, ascending unless they are rows of other evidence.
        labels: the label of each slot in them, `NO_MATCH` where there is none.
        llr: the log-likelihood ratio of each label for each point (nats), given the other labels.
        distance_llr: that of all distances between labelled points together (nats).
    """

    frames: Int[np.ndarray, " frames"]
    labels: Int[np.ndarray, "frames slots"]
    llr: Float[np.ndarray, "frames slots markers"]
    distance_llr: Float[np.ndarray, " frames"]

    def rows(self, rows: Int[np.ndarray, " rows"]) -> "FrameEvidence":
        """Some of the frames, which may repeat."""
        return FrameEvidence(self.frames[rows], self.labels[rows], self.llr[rows], self.distance_llr[rows])


def sample_frames(problem: LabellingProblem) -> Int[np.ndarray, " frames"]:
    """Evenly spaced frames, and as few more as it takes to see every trajectory at least once."""
    t, tuning = problem.trajectories, problem.tuning
    step = max(1, round(tuning.sample_seconds * t.rate), -(-t.num_frames // tuning.max_samples))
    even = np.arange(step // 2 if t.num_frames > step else 0, t.num_frames, step)
    return _with_all_seen(problem, even, np.arange(t.num_frames))


def fewer_frames(problem: LabellingProblem, frames: Int[np.ndarray, " frames"], step: int) -> Int[np.ndarray, " fewer"]:
    """Every `step`-th of the frames, and as few more of them as it takes to see every trajectory that they show."""
    return _with_all_seen(problem, frames[min(step, len(frames)) // 2 :: step], frames)


def _with_all_seen(problem: LabellingProblem, frames: np.ndarray, others: np.ndarray) -> np.ndarray:
    """The frames, and as few of the others as it takes to see every trajectory."""
    t = problem.trajectories
    first = np.searchsorted(frames, t.start)
    missed = np.flatnonzero((first >= len(frames)) | (frames[np.minimum(first, len(frames) - 1)] >= t.stop))
    more, last = [], -1
    for j in missed[np.argsort(t.stop[missed], kind="stable")]:  # by their ends: each frame stabs as many as it can
        if t.start[j] > last:
            last = int(others[np.searchsorted(others, t.stop[j]) - 1])
            more.append(last)
    return np.union1d(frames, np.array(more, dtype=frames.dtype))


def labels_in(problem: LabellingProblem, identity: np.ndarray, frames: np.ndarray) -> Int[np.ndarray, "frames slots"]:
    """The label of every slot in `frames`."""
    index = problem.trajectories.index[frames]
    return np.where(index != NO_MATCH, identity[np.maximum(index, 0)], NO_MATCH)


def evidence_in(
    problem: LabellingProblem, identity: np.ndarray, frames: Int[np.ndarray, " frames"]
) -> Control[FrameEvidence]:
    """The evidence in `frames`, given these labels."""
    labels = labels_in(problem, identity, frames)
    llr = np.empty((*labels.shape, problem.model.num_markers), np.float32)
    all_markers = np.ones((len(frames), problem.model.num_markers), bool)
    blank = FrameEvidence(frames, labels, llr, np.empty(len(frames)))
    return (yield from _judged(problem, blank, all_markers, all_markers))


def evidence_after(
    problem: LabellingProblem, before: FrameEvidence, labels: Int[np.ndarray, "frames slots"]
) -> Control[FrameEvidence]:
    """The evidence in the frames of `before`, given other labels in them.

    Only markers with a neighbour that is elsewhere now are judged anew.
    """
    markers = problem.model.num_markers
    moved = slot_of_marker(labels, markers) != slot_of_marker(before.labels, markers)
    stale = np.asarray(of_neighbours(problem, moved).any(-1))
    copy = FrameEvidence(before.frames, labels, before.llr.copy(), before.distance_llr.copy())
    return (yield from _judged(problem, copy, moved, stale))


def _judged(
    problem: LabellingProblem,
    found: FrameEvidence,
    moved: Bool[np.ndarray, "frames markers"],
    stale: Bool[np.ndarray, "frames markers"],
) -> Control[FrameEvidence]:
    """`found` with new distances in frames in which a marker `moved`, and new ratios where they are `stale`."""
    changed = np.flatnonzero(moved.any(1))
    if len(changed):
        points = problem.trajectories.points[found.frames]
        identified = by_marker(points, found.labels, problem.model.num_markers)
        found.distance_llr[changed] = distance_llr(problem, identified[changed])
        frame, marker = np.nonzero(stale)
        tables = problem.prepared.neighbourhoods
        found.llr[frame, :, marker] = yield LifeEvidence(
            identified, points, frame, marker, *tables, null=problem.prepared.null
        )
    return found


def slot_of_marker(labels: Int[np.ndarray, "frames slots"], markers: int) -> Int[np.ndarray, "frames markers"]:
    """The slot that carries each marker, `NO_MATCH` where none does."""
    slots = np.full((len(labels), markers), NO_MATCH)
    frame, slot = np.nonzero(labels != NO_MATCH)
    slots[frame, labels[frame, slot]] = slot
    return slots


def of_neighbours(
    problem: LabellingProblem, flags: Bool[np.ndarray, "frames markers"]
) -> Bool[np.ndarray, "frames markers neighbours"]:
    """The flags of the neighbours of each marker, False beyond its last one."""
    around = problem.prepared.neighbourhoods[0]
    return flags[:, np.maximum(around, 0)] & (around != NO_MATCH)


def mean_over_lives(problem: LabellingProblem, found: FrameEvidence) -> Float[np.ndarray, "trajectories markers"]:
    """Mean ratio of each label over the sampled life of each trajectory (nats)."""
    index = problem.trajectories.index[found.frames]
    shape = len(problem.trajectories), problem.model.num_markers
    total, count = np.zeros(shape), np.bincount(index[index != NO_MATCH], minlength=shape[0])
    for first in range(0, len(index), FRAMES_AT_ONCE):
        some = index[first : first + FRAMES_AT_ONCE].ravel()
        point = np.flatnonzero(some != NO_MATCH)
        sums = csr_array((np.ones(len(point)), (some[point], point)), shape=(shape[0], len(some)))
        total += sums @ found.llr[first : first + FRAMES_AT_ONCE].reshape(-1, shape[1])
    return total / np.maximum(count, 1)[:, None]
