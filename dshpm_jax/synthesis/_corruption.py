"""Ways to spoil a clean recording, and the truth to score against (section 5.2)."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._geometry import is_seen
from dshpm_jax._recording import Recording
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH

LONGEST_SECONDS = 1.0  # of a gap and of a ghost: the paper's 60 frames at 60 Hz


class Truth(NamedTuple):
    """Who is who in a recording without names.

    Attributes:
        identities: for each point a place in `names`; `NO_MATCH` for ghosts and where nothing is seen.
        names: of the markers.
    """

    identities: Int[np.ndarray, "frames points"]
    names: tuple[str, ...]

    def numbered_by(self, markers: Sequence[str]) -> Int[np.ndarray, "frames points"]:
        """The identities as places in `markers`, such as those of a model; `NO_MATCH` for what is not among them."""
        place = {name: k for k, name in enumerate(markers)}
        renumbered = np.array([place.get(name, NO_MATCH) for name in self.names] + [NO_MATCH], dtype=np.int32)
        return renumbered[self.identities]  # NO_MATCH is -1 and takes the last


def open_gaps(
    recording: Recording, fraction: float, rng: np.random.Generator, longest_seconds: float = LONGEST_SECONDS
) -> Recording:
    """Removes `fraction` of the points in gaps of up to `longest_seconds`, evenly among the columns (section 5.2.2).

    The share, 0 to 1, is of the points that are seen and met to the point; the same `rng` opens the same gaps.
    """
    _check_fraction(fraction, 1.0)
    points = np.array(recording.points)
    seen = np.array(recording.present)
    quota = round(fraction * seen.sum())
    longest = _longest(recording, longest_seconds)
    columns: list[int] = []
    while quota > 0:
        columns = columns or list(rng.permutation(seen.shape[1]))  # each once before any comes again
        column, length = columns.pop(), int(rng.integers(1, longest + 1))
        start = int(rng.integers(0, len(seen) - length + 1))
        hit = start + np.flatnonzero(seen[start : start + length, column])[:quota]
        seen[hit, column] = False
        quota -= len(hit)
    points[~seen] = np.nan
    return replace(recording, points=points)


def add_ghosts(
    recording: Recording,
    fraction: float,
    rng: np.random.Generator,
    near: bool = False,
    longest_seconds: float = LONGEST_SECONDS,
) -> Recording:
    """Adds false trajectories: `fraction` as many points as there are frames times labelled columns (section 5.2.2).

    A ghost lasts 1 frame to `longest_seconds`, goes straight from one random place to another, and has a column of its
    own without a name. The places are drawn in the box about the whole take, as in the paper; with `near`, in the box
    about the points seen in those frames, where a ghost is far harder to tell from a marker. `rng` draws them.
    """
    _check_fraction(fraction, np.inf)
    quota = round(fraction * recording.num_frames * int(recording.labelled.sum()))
    if not quota:
        return recording
    ghosts: list[np.ndarray] = []
    longest = _longest(recording, longest_seconds)
    whole = _box(recording.points)
    while quota > 0:
        length = min(int(rng.integers(1, longest + 1)), quota)
        start = int(rng.integers(0, recording.num_frames - length + 1))
        ends = (start, start + length - 1)
        first, last = (rng.uniform(*(_box(recording.points[t], whole) if near else whole)) for t in ends)
        ghost = np.full((recording.num_frames, 3), np.nan)
        ghost[start : start + length] = first + np.linspace(0, 1, length)[:, None] * (last - first)
        ghosts.append(ghost)
        quota -= length
    names = tuple(f"*{k}" for k in range(1, len(ghosts) + 1))
    points = np.concatenate([recording.points, np.stack(ghosts, axis=1)], axis=1)
    return Recording(points, recording.labels + names, recording.rate, recording.unit)


def distort(recording: Recording, level: float, segment_length: float, rng: np.random.Generator) -> Recording:
    """Adds independent noise, drawn by `rng`, to every coordinate of every point (section 5.2.1).

    The standard deviation is 0.5 `level` `segment_length` / sqrt(6): the difference of two points has six such
    coordinates in it, so its root mean square changes by half the distortion level times the mean segment length (mm).
    """
    spread = 0.5 * level * segment_length / np.sqrt(6)
    return replace(recording, points=recording.points + rng.normal(0.0, spread, recording.points.shape))


def scramble(recording: Recording, rng: np.random.Generator, trajectories: bool = True) -> tuple[Recording, Truth]:
    """The recording without names and in random order, and the truth about it.

    Arguments:
        recording: labelled columns are markers, those without a name are ghosts.
        rng: draws the order.
        trajectories: each unbroken path gets a column of its own; otherwise the points of every frame are shuffled over
            the columns and nothing tells which continues which.
    """
    names = tuple(label for label, named in zip(recording.labels, recording.labelled, strict=True) if named)
    identity = np.full(len(recording.labels), NO_MATCH, dtype=np.int32)
    identity[recording.labelled] = np.arange(len(names))
    shuffled = _cut if trajectories else _shuffle
    points, identities = shuffled(recording, identity, rng)
    bare = Recording(points, tuple(f"*{k}" for k in range(1, points.shape[1] + 1)), recording.rate, recording.unit)
    return bare, Truth(identities, names)


def _cut(recording: Recording, identity, rng: np.random.Generator):
    """A column for each trajectory."""
    paths = from_columns(recording.points, recording.rate)
    order = rng.permutation(len(paths))
    points = np.full((recording.num_frames, len(paths), 3), np.nan)
    identities = np.full(points.shape[:2], NO_MATCH, dtype=np.int32)
    for column, j in enumerate(order):
        life = slice(paths.start[j], paths.stop[j])
        source = paths.column[paths.start[j], paths.slot[j]]
        points[life, column] = recording.points[life, source]
        identities[life, column] = identity[source]
    return points, identities


def _shuffle(recording: Recording, identity, rng: np.random.Generator):
    """The points of each frame in random order, in as many columns as the fullest frame needs."""
    present = recording.present
    keys = np.where(present, rng.uniform(size=present.shape), 2.0)  # those not seen go to the end
    order = np.argsort(keys, axis=1)[:, : int(present.sum(1).max(initial=0))]
    points = np.take_along_axis(recording.points, order[..., None], axis=1)
    return points, np.where(np.take_along_axis(present, order, axis=1), identity[order], NO_MATCH)


def _box(
    points: Float[np.ndarray, "*frames points 3"], otherwise: tuple[np.ndarray, np.ndarray] | None = None
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """Two corners of the box about the points seen, or `otherwise` where there are none (mm)."""
    seen = points[is_seen(points)]
    if len(seen):
        return seen.min(0), seen.max(0)
    if otherwise is None:
        raise ValueError("no point is seen in any frame; ghosts have no place to be")
    return otherwise


def _longest(recording: Recording, seconds: float) -> int:
    return max(1, min(recording.num_frames, round(seconds * recording.rate)))


def _check_fraction(fraction: float, below: float) -> None:
    if not 0 <= fraction < below:
        raise ValueError(f"got the fraction {fraction}: give a share of the points from 0 up to {below:g}, as in 0.1")
