"""Answers to `SignedVolumes`."""

import numpy as np

from dshpm_jax._buckets import FOUR_BUCKETS, POINT_BUCKETS, START_BUCKETS, bucket
from dshpm_jax._kernels.signed_volumes import volume_llr
from dshpm_jax._requests import SignedVolumes
from dshpm_jax._types import NO_MATCH

FRAMES = (8, 32)
"""count; frames are padded to these, with points that are not seen."""


def volumes(requests: list[SignedVolumes]) -> list[np.ndarray]:
    """What the volumes of each request say."""
    return [_of(asked) for asked in requests]


def _of(asked: SignedVolumes) -> np.ndarray:
    count, own = asked.labels.shape
    if not len(asked.fours) or not count:
        return np.zeros((count, len(asked.fours)))
    frames = bucket(len(asked.points), FRAMES, "frames of a moment")
    points = np.full((frames, bucket(own, POINT_BUCKETS, "points"), 3), np.nan, np.float32)
    seen = np.isfinite(asked.points)
    centre = np.where(seen, asked.points, 0.0).sum(1, keepdims=True) / np.maximum(seen.sum(1, keepdims=True), 1)
    points[: len(asked.points), :own] = asked.points - centre
    labels = np.full((bucket(count, START_BUCKETS, "labellings"), points.shape[1]), NO_MATCH, np.int32)
    labels[:count, :own] = asked.labels
    size = bucket(len(asked.fours), FOUR_BUCKETS, "fours")
    fours = np.zeros((size, 4), np.int32)
    mean, sd = np.zeros(size, np.float32), np.full(size, np.inf, np.float32)
    fours[: len(asked.fours)], mean[: len(asked.fours)], sd[: len(asked.fours)] = asked.fours, asked.mean, asked.sd
    found = volume_llr(points, labels, fours, mean, sd, *(np.float32(x) for x in asked.numbers))
    return np.asarray(found)[:count, : len(asked.fours)].astype(float)
