"""Answers to `SignedVolumes`."""

import numpy as np

from dshpm_jax._buckets import FOUR_BUCKETS, POINT_BUCKETS, bucket
from dshpm_jax._kernels.signed_volumes import volume_llr
from dshpm_jax._requests import SignedVolumes
from dshpm_jax._types import NO_MATCH

FRAMES = (16,)
"""count; frames are padded to this, with points that are not seen."""

LABELLINGS = (4, 16)
"""count; labellings in one call, always: programs of several sizes round differently."""


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
    size = bucket(len(asked.fours), FOUR_BUCKETS, "fours")
    fours = np.zeros((size, 4), np.int32)
    mean, sd = np.zeros(size, np.float32), np.full(size, np.inf, np.float32)
    fours[: len(asked.fours)], mean[: len(asked.fours)], sd[: len(asked.fours)] = asked.fours, asked.mean, asked.sd
    numbers = [np.float32(x) for x in asked.numbers]
    found = np.zeros((count, len(asked.fours)))
    most = min(bucket(min(count, LABELLINGS[-1]), LABELLINGS, "labellings"), LABELLINGS[-1])
    for first in range(0, count, most):
        some = asked.labels[first : first + most]
        labels = np.full((most, points.shape[1]), NO_MATCH, np.int32)
        labels[: len(some), :own] = some
        llr = np.asarray(volume_llr(points, labels, fours, mean, sd, *numbers))
        found[first : first + most] = llr[: len(some), : len(asked.fours)]
    return found
