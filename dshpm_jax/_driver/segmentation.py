"""Answers to `Segmentation`, some windows in a call."""

import numpy as np

from dshpm_jax._buckets import POINT_BUCKETS, bucket
from dshpm_jax._kernels.pair_statistics import segmentation_matrices
from dshpm_jax._requests import Segmentation

WINDOWS, WINDOW_FRAMES = 8, 11  # pre-segmentation windows in one call, and frames of each


def segment(requests: list[Segmentation]) -> list[np.ndarray]:
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
