"""Recordings of one made person, in files."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from dshpm_jax import Recording, io
from dshpm_jax.synthesis import person

MARKERS = 34


def taken(activity: str = "freeform", seed: int = 0, frames: int = 90) -> Recording:
    return person(MARKERS, activity, frames, subject=1, seed=seed).recording


def without(recording: Recording, *names: str) -> Recording:
    kept = [k for k, label in enumerate(recording.labels) if label not in names]
    return Recording(recording.points[:, kept], tuple(recording.labels[k] for k in kept), recording.rate)


def exchanged(recording: Recording, one: str, other: str, frames: slice = slice(None)) -> Recording:
    points = recording.points.copy()
    a, b = recording.labels.index(one), recording.labels.index(other)
    points[frames, a], points[frames, b] = recording.points[frames, b], recording.points[frames, a]
    return replace(recording, points=points)


def nameless(recording: Recording) -> Recording:
    return replace(recording, labels=tuple(f"*{k}" for k in range(len(recording.labels))))


def write(folder: Path, **recordings: Recording) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    for name, recording in recordings.items():
        io.write_c3d(recording, folder / f"{name}.c3d")
    return folder


def wand() -> Recording:
    rng = np.random.default_rng(0)
    return Recording(rng.normal(0, 200, (1, 5, 3)) + rng.normal(0, 5, (90, 5, 3)), tuple("VWXYZ"), 60.0)
