"""Synthetic subjects of one marker set, made once for all tests."""

from functools import cache

import numpy as np

from dshpm_jax import MarkerSet, Recording
from dshpm_jax.synthesis import person

MARKERS, OTHERS, FRAMES = 34, 3, 90


@cache
def recording(subject: int, seed: int = 0, frames: int = FRAMES) -> Recording:
    return person(MARKERS, frames=frames, subject=subject, seed=seed).recording


@cache
def marker_set() -> MarkerSet:
    return MarkerSet.from_subjects({f"s{k}": [recording(k, seed=k)] for k in range(1, OTHERS + 1)})


def unnamed(given: Recording, seed: int = 0) -> tuple[Recording, np.ndarray]:
    """The recording with its columns shuffled and unnamed, and the marker of the set in each."""
    order = np.random.default_rng(seed).permutation(given.points.shape[1])
    names = [f"*{k}" for k in range(len(order))]
    markers = marker_set().markers
    return Recording(given.points[:, order], tuple(names), given.rate), np.array(
        [markers.index(given.labels[k]) for k in order]
    )
