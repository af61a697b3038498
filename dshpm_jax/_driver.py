"""The only door between host and device: gathers what many controls ask for, answers it in few kernel calls.

A control is a generator that yields requests (`_requests`). The driver runs many of them, takes the requests that are
waiting, groups those of one kind and bucket, pads them to a few shapes, calls a jitted kernel once a group and sends
each its answer. An answer never depends on who shared the batch.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from dshpm_jax._kernels.candidate_table import Hypotheses, Problems
from dshpm_jax._kernels.life_evidence import life_evidence
from dshpm_jax._kernels.match_scores import score_matches
from dshpm_jax._kernels.matching import match_segments
from dshpm_jax._kernels.pair_statistics import segmentation_matrices
from dshpm_jax._kernels.poses import fit_poses
from dshpm_jax._requests import (
    Control,
    FitPoses,
    LifeEvidence,
    MatchSegment,
    Poses,
    ScoreMatch,
    Segmentation,
    SegmentMatches,
    Together,
)
from dshpm_jax._scoring import (
    AbstractCandidateScore,
    AbstractMatchScore,
    MeanResidual,
    ToleranceScore,
    check_candidate_score,
    check_match_score,
)
from dshpm_jax._types import NO_MATCH

POINT_BUCKETS = (64, 128, 256, 512, 1024)
COLUMN_BUCKETS = (8, 18)
HYPOTHESIS_BUCKETS = (4096, 32768)  # small calls take no longer in a large bucket, and every size is one more program
FULL_BATCH = 4096  # hypotheses in one call, unless a single request has more
FIT_BUCKETS = (64, 1024)
REQUESTS = 32  # segments in one call, always padded to this many
SLOT_BUCKETS = (32, 64, 96, 128, 192, *POINT_BUCKETS[2:])  # life evidence takes time for every slot, so these are finer
LIFE_LANES = 1024  # markers in frames in one call, always: programs of several sizes round differently
WINDOWS, WINDOW_FRAMES = 8, 11  # pre-segmentation windows in one call, and frames of each
FAR = 1e6  # mm, where padded points are


def bucket(size: int, buckets: Sequence[int], what: str) -> int:
    """The smallest bucket that holds `size`."""
    for limit in buckets:
        if size <= limit:
            return limit
    raise ValueError(f"{size} {what} at once, more than {buckets[-1]}: this recording is too crowded to label")


class Driver:
    """Runs controls over the kernels.

    Arguments:
        candidate_score: how badly a candidate fits its column (Eq. 3).
        match_score: how badly a match fits its segment (Eq. 4).
            Both are tried on plausible numbers first; a `ValueError` names one that fails or answers with NaN.
        in_flight: controls that run at the same time; more make fuller batches and take more memory.
    """

    def __init__(
        self,
        candidate_score: AbstractCandidateScore | None = None,
        match_score: AbstractMatchScore | None = None,
        in_flight: int = 64,
    ):
        if candidate_score is not None:
            check_candidate_score(candidate_score)
        if match_score is not None:
            check_match_score(match_score)
        self._candidate_score = ToleranceScore() if candidate_score is None else candidate_score
        self._match_score = MeanResidual() if match_score is None else match_score
        self._in_flight = in_flight

    def run(self, controls: Iterable[Control]) -> Iterator[Any]:
        """The results of `controls`, in their order, each as soon as it and those before it are done."""
        waiting = iter(controls)
        done: dict[int, Any] = {}
        threads: dict[int, _Thread] = {}
        started = following = 0
        exhausted = False
        while True:
            while not exhausted and len(threads) < self._in_flight:
                control = next(waiting, None)
                if control is None:
                    exhausted = True
                else:
                    threads[started] = _Thread(control)
                    started += 1
            self._answer([leaf for thread in threads.values() for leaf in thread.leaves()])
            for k, thread in list(threads.items()):
                if thread.advance():
                    done[k] = threads.pop(k).result
            while following in done:
                yield done.pop(following)
                following += 1
            if exhausted and not threads:
                return

    def _answer(self, leaves: "list[_Thread]") -> None:
        groups: dict[Any, list[_Thread]] = defaultdict(list)
        for leaf in leaves:
            groups[_group_of(leaf.request)].append(leaf)
        for group, members in groups.items():
            answer = {
                MatchSegment: self._match,
                ScoreMatch: self._score,
                FitPoses: _fit,
                Segmentation: _segment,
                LifeEvidence: _cost,
            }[group[0]]
            distinct = {id(leaf.request): leaf.request for leaf in members}  # controls may wait for the same request
            answers = dict(zip(distinct, answer(list(distinct.values()))))
            for member in members:
                member.answer = answers[id(member.request)]

    def _match(self, requests: list[MatchSegment]) -> list[SegmentMatches]:
        answers: list[SegmentMatches] = []
        for batch in _batches(requests, lambda r: len(r.pivot), FULL_BATCH):
            answers += self._match_batch(batch)
        return answers

    def _match_batch(self, requests: list[MatchSegment]) -> list[SegmentMatches]:
        problems, hypotheses = _pad(requests)
        found = match_segments(problems, hypotheses, self._candidate_score, self._match_score)
        count = int(found.num_tables)
        rows = [np.asarray(field) for field in found[:6]]
        request = hypotheses.request[rows[0][:count]]
        ends = np.searchsorted(request, np.arange(len(requests) + 1))
        answers = []
        for k, asked in enumerate(requests):
            mine = slice(ends[k], ends[k + 1])
            _, assigned, matched, error, accepted, fits = (field[mine] for field in rows)
            columns = len(asked.target.markers)
            answers.append(SegmentMatches(assigned[:, :columns], matched, error, accepted, fits, int(found.truncated)))
        return answers

    def _score(self, requests: list[ScoreMatch]) -> list[float]:
        columns = bucket(max(len(r.scale) for r in requests), COLUMN_BUCKETS, "markers of a segment")
        rows = FIT_BUCKETS[0]
        answers: list[float] = []
        for first in range(0, len(requests), rows):
            batch = requests[first : first + rows]
            residuals, matched = np.zeros((rows, columns), np.float32), np.zeros((rows, columns), bool)
            scale = np.ones((rows, columns), np.float32)
            for k, asked in enumerate(batch):
                size = len(asked.scale)
                residuals[k, :size], scale[k, :size], matched[k, :size] = asked.residuals, asked.scale, asked.matched
            found = np.asarray(score_matches(self._match_score, residuals, scale, matched))
            answers += found[: len(batch)].tolist()
        return answers


class _Thread:
    """A control in flight, with the threads below it if it waits for several."""

    def __init__(self, control: Control):
        self._control = control
        self._below: list[_Thread] = []
        self.request: Any = None
        self.answer: Any = None
        self.result: Any = None
        self._done = False
        self._step(None)

    def _step(self, answer: Any) -> None:
        try:
            self.request = self._control.send(answer)
        except StopIteration as stop:
            self.result, self._done, self.request = stop.value, True, None
            return
        if isinstance(self.request, Together):
            self._below = [_Thread(control) for control in self.request.controls]

    def leaves(self) -> "list[_Thread]":
        """The threads at or below this one that wait for a kernel."""
        if self._done:
            return []
        if isinstance(self.request, Together):
            return [leaf for thread in self._below for leaf in thread.leaves()]
        return [self]

    def advance(self) -> bool:
        """Goes on with the answers that have come; whether the control is done."""
        if self._done:
            return True
        if isinstance(self.request, Together):
            if all([thread.advance() for thread in self._below]):
                self._step([thread.result for thread in self._below])
        else:
            self._step(self.answer)
        return self._done


def _group_of(request: Any) -> tuple:
    if isinstance(request, MatchSegment):
        points = bucket(len(request.points), POINT_BUCKETS, "points")
        return MatchSegment, points, bucket(len(request.target.markers), COLUMN_BUCKETS, "markers of a segment")
    if isinstance(request, FitPoses):
        return FitPoses, bucket(request.shape.shape[1], COLUMN_BUCKETS, "markers of a segment")
    if isinstance(request, ScoreMatch):
        return ScoreMatch, bucket(len(request.scale), COLUMN_BUCKETS, "markers of a segment")
    if isinstance(request, Segmentation):
        return (Segmentation,)
    if isinstance(request, LifeEvidence):
        return LifeEvidence, bucket(request.points.shape[1], SLOT_BUCKETS, "points")
    raise TypeError(f"a control yielded {type(request).__name__}, which is no request")


def _batches(requests: list, size: Callable[[Any], int], limit: int) -> Iterator[list]:
    """Runs of requests that together stay within `limit` and `REQUESTS`."""
    batch: list = []
    total = 0
    for request in requests:
        if batch and (total + size(request) > limit or len(batch) == REQUESTS):
            yield batch
            batch, total = [], 0
        batch.append(request)
        total += size(request)
    if batch:
        yield batch


def _pad(requests: list[MatchSegment]) -> tuple[Problems, Hypotheses]:
    """The requests of one bucket as arrays; padded points are far away and not free, padded columns are none."""
    first = requests[0]
    points = bucket(len(first.points), POINT_BUCKETS, "points")
    columns = bucket(len(first.target.markers), COLUMN_BUCKETS, "markers of a segment")
    empty: dict[str, Any] = dict(
        points=np.full((REQUESTS, points, 3), FAR, np.float32),
        free=np.zeros((REQUESTS, points), bool),
        rigid=np.zeros((REQUESTS, points, points), bool),
        pinned=np.full((REQUESTS, columns), NO_MATCH, np.int32),
        shape=np.zeros((REQUESTS, columns, 3), np.float32),
        distance=np.zeros((REQUESTS, columns, columns), np.float32),
        tolerance=np.ones((REQUESTS, columns, columns), np.float32),
        scale=np.ones((REQUESTS, columns), np.float32),
        reach=np.zeros((REQUESTS, columns), np.float32),
        is_column=np.zeros((REQUESTS, columns), bool),
        is_marker=np.zeros((REQUESTS, columns), bool),
        need=np.zeros(REQUESTS, np.int32),
    )
    problems = Problems(**empty)
    for k, asked in enumerate(requests):
        target, n, m = asked.target, len(asked.points), len(asked.target.markers)
        problems.points[k, :n] = asked.points - asked.points.mean(0)
        problems.free[k, :n] = asked.free
        problems.rigid[k, :n, :n] = asked.rigid
        problems.pinned[k, :m] = asked.pinned
        problems.shape[k, :m] = target.shape
        problems.distance[k, :m, :m] = target.distance
        problems.tolerance[k, :m, :m] = target.tolerance
        problems.scale[k, :m] = target.scale
        problems.reach[k, :m] = target.reach
        problems.is_column[k, :m] = True
        problems.is_marker[k, :m] = target.markers != NO_MATCH
        problems.need[k] = target.need
    return problems, _pad_hypotheses(requests)


def _pad_hypotheses(requests: list[MatchSegment]) -> Hypotheses:
    sizes = [len(asked.pivot) for asked in requests]
    total = bucket(sum(sizes), HYPOTHESIS_BUCKETS, "hypotheses of a segment")
    fields = [
        np.repeat(np.arange(len(requests)), sizes),
        np.concatenate([asked.pivot for asked in requests]),
        np.concatenate([asked.assumed for asked in requests]),
        np.ones(sum(sizes), bool),
    ]
    padded = [np.zeros(total, field.dtype if field.dtype == bool else np.int32) for field in fields]
    for whole, field in zip(padded, fields):
        whole[: len(field)] = field
    padded[0][sum(sizes) :] = REQUESTS - 1
    return Hypotheses(*padded)  # type: ignore[arg-type]


def _fit(requests: list[FitPoses]) -> list[Poses]:
    answers: list[Poses] = []
    columns = bucket(max(r.shape.shape[1] for r in requests), COLUMN_BUCKETS, "markers of a segment")
    sizes = [len(r.shape) for r in requests]
    shape = np.zeros((sum(sizes), columns, 3), np.float32)
    points = np.zeros((sum(sizes), columns, 3), np.float32)
    weights = np.zeros((sum(sizes), columns), np.float32)
    centre = np.zeros((sum(sizes), 3))
    start = 0
    for r, size in zip(requests, sizes):
        rows, m = slice(start, start + size), r.shape.shape[1]
        used = r.weights > 0
        count = np.maximum(used.sum(1), 1)[:, None]
        here = np.where(used[..., None], r.points, 0.0)
        centre[rows] = here.sum(1) / count
        shape[rows, :m] = r.shape
        points[rows, :m] = np.where(used[..., None], here - centre[rows, None], 0.0)
        weights[rows, :m] = np.where(used, r.weights, 0.0)
        start += size
    rotation, translation, rms, rank = _fit_in_buckets(shape, points, weights)
    translation = translation + centre
    start = 0
    for size in sizes:
        rows = slice(start, start + size)
        answers.append(Poses(rotation[rows], translation[rows], rms[rows], rank[rows]))
        start += size
    return answers


def _fit_in_buckets(shape, points, weights) -> list[np.ndarray]:
    found = []
    for first in range(0, len(shape), FIT_BUCKETS[-1]):
        rows = slice(first, first + FIT_BUCKETS[-1])
        size = len(shape[rows])
        extra = bucket(size, FIT_BUCKETS, "fits") - size
        padded = [np.concatenate([x[rows], np.zeros((extra, *x.shape[1:]), x.dtype)]) for x in (shape, points, weights)]
        found.append([np.asarray(x)[:size] for x in fit_poses(*padded)])
    return [np.concatenate(parts) for parts in zip(*found)]


def _segment(requests: list[Segmentation]) -> list[np.ndarray]:
    """Segmentation matrices, some windows in a call; frames and points beyond a window's own are absent."""
    answers = []
    for first in range(0, len(requests), WINDOWS):
        batch = requests[first : first + WINDOWS]
        frames = max(WINDOW_FRAMES, *(len(asked.window) for asked in batch))
        points = bucket(max(asked.window.shape[1] for asked in batch), POINT_BUCKETS, "points")
        window = np.full((WINDOWS, frames, points, 3), np.nan, np.float32)
        limits = np.zeros((2, WINDOWS), np.float32)
        for k, asked in enumerate(batch):
            here = asked.window - _middle(asked.window)
            window[k, : here.shape[0], : here.shape[1]] = here
            limits[:, k] = asked.max_extent, asked.max_ratio
        found = np.asarray(segmentation_matrices(window, np.isfinite(window[..., 0]), *limits))
        answers += [found[k, : asked.window.shape[1], : asked.window.shape[1]] for k, asked in enumerate(batch)]
    return answers


def _middle(window: np.ndarray) -> np.ndarray:
    """The mean of all points that are seen; the origin where none is, as a frame at its extremes may leave it."""
    seen = np.isfinite(window)
    return np.where(seen, window, 0).sum((0, 1)) / np.maximum(seen.sum((0, 1)), 1)


def _cost(requests: list[LifeEvidence]) -> list[np.ndarray]:
    """Evidence of the lanes of all requests, packed into calls of a few sizes."""
    answers = [np.empty((len(asked.marker), asked.points.shape[1]), np.float32) for asked in requests]
    for pieces in _packed([len(asked.marker) for asked in requests], LIFE_LANES):
        lanes = [_life_lanes(requests[k], rows) for k, rows in pieces]
        found = np.asarray(life_evidence(*_stacked(lanes, LIFE_LANES)))
        first = 0
        for k, rows in pieces:
            last = first + rows.stop - rows.start
            answers[k][rows] = found[: answers[k].shape[1], first:last].T
            first = last
    return answers


def _packed(sizes: Sequence[int], limit: int) -> Iterator[list[tuple[int, slice]]]:
    """Slices of rows, each with whose it is, in groups of `limit` rows; only the last group may have fewer."""
    group: list[tuple[int, slice]] = []
    room = limit
    for k, size in enumerate(sizes):
        first = 0
        while first < size:
            last = min(first + room, size)
            group.append((k, slice(first, last)))
            room -= last - first
            first = last
            if not room:
                yield group
                group, room = [], limit
    if group:
        yield group


def _life_lanes(asked: LifeEvidence, rows: slice) -> list[np.ndarray]:
    """The kernel's arguments for some lanes, the lane first; coordinates about the middle of the frame's points."""
    frame, marker = asked.frame[rows], asked.marker[rows]
    used = np.unique(frame)
    row = np.searchsorted(used, frame)
    points, identified = asked.points[used], asked.identified[used]
    seen = np.isfinite(points)
    centre = np.where(seen, points, 0.0).sum(1, keepdims=True) / np.maximum(seen.sum(1, keepdims=True), 1)
    wide = bucket(points.shape[1], SLOT_BUCKETS, "points")
    here = np.full((len(used), wide, 3), np.nan, np.float32)
    here[:, : points.shape[1]] = points - centre
    around = asked.neighbours[marker]
    places = (identified - centre).astype(np.float32)[row[:, None], np.maximum(around, 0)]
    places = np.where((around != NO_MATCH)[..., None], places, np.float32(np.nan))
    return [here[row], places, asked.shape[marker], asked.own[marker], asked.softness[marker], asked.spread[marker]]


def _stacked(pieces: list[list[np.ndarray]], size: int) -> list[np.ndarray]:
    """The pieces one after the other, padded to `size` lanes by repeating the last; the lane becomes the last axis."""
    stacked = []
    for parts in zip(*pieces):
        whole = np.concatenate(parts)
        whole = np.concatenate([whole, np.repeat(whole[-1:], size - len(whole), axis=0)])
        stacked.append(np.moveaxis(whole, 0, -1))
    return stacked
