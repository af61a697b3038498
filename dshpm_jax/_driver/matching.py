"""Answers to `MatchSegment`, many in a call, and to `ScoreMatch`."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from dshpm_jax._buckets import COLUMN_BUCKETS, FIT_BUCKETS, POINT_BUCKETS, bucket
from dshpm_jax._kernels.candidate_table import Hypotheses, Problems
from dshpm_jax._kernels.match_scores import score_matches
from dshpm_jax._kernels.matching import match_segments
from dshpm_jax._requests import MatchSegment, ScoreMatch, SegmentMatches
from dshpm_jax._scoring import AbstractCandidateScore, AbstractMatchScore
from dshpm_jax._types import NO_MATCH

HYPOTHESIS_BUCKETS = (4096, 32768)  # small calls take no longer in a large bucket, and every size is one more program
FULL_BATCH = 4096  # hypotheses in one call, unless a single request has more
REQUESTS = 32  # segments in one call, always padded to this many
FAR = 1e6  # mm, where padded points are


def match(
    requests: list[MatchSegment], candidate_score: AbstractCandidateScore, match_score: AbstractMatchScore
) -> list[SegmentMatches]:
    """The matches of each request."""
    return [answer for batch in _batches(requests) for answer in _match_batch(batch, candidate_score, match_score)]


def score(requests: list[ScoreMatch], match_score: AbstractMatchScore) -> list[float]:
    """The cost of each match."""
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
        found = np.asarray(score_matches(match_score, residuals, scale, matched))
        answers += found[: len(batch)].tolist()
    return answers


def _batches(requests: list[MatchSegment]) -> Iterator[list[MatchSegment]]:
    """Runs of requests that together stay within `FULL_BATCH` hypotheses and `REQUESTS`."""
    batch: list[MatchSegment] = []
    total = 0
    for request in requests:
        size = len(request.pivot)
        if batch and (total + size > FULL_BATCH or len(batch) == REQUESTS):
            yield batch
            batch, total = [], 0
        batch.append(request)
        total += size
    if batch:
        yield batch


def _match_batch(
    requests: list[MatchSegment], candidate_score: AbstractCandidateScore, match_score: AbstractMatchScore
) -> list[SegmentMatches]:
    problems, hypotheses = pad(requests)
    found = match_segments(problems, hypotheses, candidate_score, match_score)
    count = int(found.num_tables)
    rows = [np.asarray(field) for field in found[:-1]]
    request = hypotheses.request[rows[0][:count]]
    ends = np.searchsorted(request, np.arange(len(requests) + 1))
    answers = []
    for k, asked in enumerate(requests):
        mine = slice(ends[k], ends[k + 1])
        _, assigned, matched, error, accepted, fits = (field[mine] for field in rows)
        columns = len(asked.target.markers)
        answers.append(SegmentMatches(assigned[:, :columns], matched, error, accepted, fits))
    return answers


def pad(requests: list[MatchSegment]) -> tuple[Problems, Hypotheses]:
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
