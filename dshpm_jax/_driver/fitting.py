"""Answers to `FitPoses`, many in a call."""

import numpy as np

from dshpm_jax._buckets import COLUMN_BUCKETS, FIT_BUCKETS, bucket
from dshpm_jax._kernels.poses import fit_poses
from dshpm_jax._requests import FitPoses, FittedPoses


def fit(requests: list[FitPoses]) -> list[FittedPoses]:
    """The poses of each request."""
    answers: list[FittedPoses] = []
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
        answers.append(FittedPoses(rotation[rows], translation[rows], rms[rows], rank[rows]))
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
