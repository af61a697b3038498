"""Answers to `LifeEvidence`, the lanes of many requests in a call."""

from collections.abc import Iterator, Sequence

import numpy as np

from dshpm_jax._buckets import SLOT_BUCKETS, bucket
from dshpm_jax._kernels.life_evidence import life_evidence
from dshpm_jax._requests import LifeEvidence
from dshpm_jax._types import NO_MATCH

LIFE_LANES = 1024  # markers in frames in one call, always: programs of several sizes round differently


def life_evidences(requests: list[LifeEvidence]) -> list[np.ndarray]:
    """Log-likelihood ratios of the lanes of all requests, packed into calls of one size; all have one null model."""
    answers = [np.empty((len(asked.marker), asked.points.shape[1]), np.float32) for asked in requests]
    for pieces in _packed([len(asked.marker) for asked in requests], LIFE_LANES):
        lanes = [_life_lanes(requests[k], rows) for k, rows in pieces]
        found = np.asarray(life_evidence(*_stacked(lanes, LIFE_LANES), null=requests[0].null))
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
    return [
        here[row],
        places,
        asked.shape[marker],
        asked.own[marker],
        asked.distance_sd[marker],
        asked.marker_sd[marker],
    ]


def _stacked(pieces: list[list[np.ndarray]], size: int) -> list[np.ndarray]:
    """The pieces one after the other, padded to `size` lanes by repeating the last; the lane becomes the last axis."""
    stacked = []
    for parts in zip(*pieces):
        whole = np.concatenate(parts)
        whole = np.concatenate([whole, np.repeat(whole[-1:], size - len(whole), axis=0)])
        stacked.append(np.moveaxis(whole, 0, -1))
    return stacked
