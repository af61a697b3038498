"""Answers to `ClimbLabels` and `SoftenLabels`, the moments of many recordings in a call."""

from collections.abc import Iterator, Sequence

import jax
import numpy as np

from dshpm_jax._buckets import MARKER_BUCKETS, POINT_BUCKETS, START_BUCKETS, bucket
from dshpm_jax._kernels.quadratic_assignment import PairScores, climb, soften
from dshpm_jax._requests import ClimbedLabels, ClimbLabels, PairTable, SoftenLabels
from dshpm_jax._types import NO_MATCH

PROBLEMS, PROBLEMS_ON_CPU = 8, 1
"""count; moments in one call, always: programs of several sizes round differently. A core gains nothing from more."""


def climbed(requests: list[ClimbLabels]) -> list[ClimbedLabels]:
    """The labellings of each request, which all have one group."""
    answers = []
    for some, size in _batches(requests):
        points, markers, starts = _sizes(some[0].pairs, len(some[0].labels))
        labels = np.full((size, starts, points), NO_MATCH, np.int32)
        for k, asked in enumerate(some):
            labels[k, : len(asked.labels), : asked.labels.shape[1]] = asked.labels
        scores = _stacked([asked.pairs for asked in some], size)
        found = [np.asarray(part) for part in climb(scores, labels, np.int32(some[0].steps))]
        for k, asked in enumerate(some):
            count, own = asked.labels.shape
            benefit = found[2][k, :count, :own, : len(asked.pairs.table)]
            answers.append(ClimbedLabels(found[0][k, :count, :own], found[1][k, :count].astype(float), benefit))
    return answers


def softened(requests: list[SoftenLabels]) -> list[np.ndarray]:
    """What labels say for the points of each request, which all have one group."""
    answers = []
    for some, size in _batches(requests):
        points, markers, _ = _sizes(some[0].pairs, 1)
        start = np.zeros((size, len(some[0].start), points, markers), np.float32)
        for k, asked in enumerate(some):
            start[k, :, : asked.start.shape[1], : asked.start.shape[2]] = asked.start
        scores = _stacked([asked.pairs for asked in some], size)
        found = np.asarray(soften(scores, start, some[0].sharpness.astype(np.float32)))
        answers += [found[k, :, : a.start.shape[1], : a.start.shape[2]] for k, a in enumerate(some)]
    return answers


def _batches(requests: Sequence) -> Iterator[tuple[list, int]]:
    """Requests in calls of one size each."""
    size = PROBLEMS_ON_CPU if jax.default_backend() == "cpu" else PROBLEMS
    for first in range(0, len(requests), size):
        yield list(requests[first : first + size]), size


def _sizes(pairs: PairTable, starts: int) -> tuple[int, int, int]:
    points, markers, _ = pairs.group()
    return points, markers, bucket(starts, START_BUCKETS, "labellings")


def _stacked(tables: Sequence[PairTable], size: int) -> PairScores:
    """The tables of some moments, padded."""
    points = bucket(tables[0].node.shape[0], POINT_BUCKETS, "points")
    markers = bucket(len(tables[0].table), MARKER_BUCKETS, "markers of a set")
    nodes, corners = tables[0].table.shape[1], tables[0].node.shape[2]
    table = np.zeros((size, markers, nodes, markers), np.float32)
    node = np.zeros((size, points, points, corners), np.int32)
    weight = np.zeros((size, points, points, corners), np.float32)
    there, worn = np.zeros((size, points), bool), np.zeros((size, markers), bool)
    for k, one in enumerate(tables):
        n, m = one.node.shape[0], len(one.table)
        table[k, :m, :, :m], node[k, :n, :n], weight[k, :n, :n] = one.table, one.node, one.weight
        there[k, :n], worn[k, :m] = True, True
    unlabelled = np.array([one.unlabelled for one in tables], np.float32)
    return PairScores(table, node, weight, there, worn, unlabelled)  # type: ignore[arg-type]
