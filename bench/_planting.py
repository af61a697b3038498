"""Errors planted in labelled recordings, and what `check` says of them."""

from collections.abc import Iterator, Mapping

import numpy as np
from _truth import places_of
from jaxtyping import Float, Int

from dshpm_jax import Recording, SubjectModel, check

EXCHANGES, LEAPS = 4, 2  # in a recording
NEAREST = 3  # a marker is exchanged with one of so many that are nearest to it
LEAP_MM = 40.0, 120.0
LEAP_SECONDS = 0.1  # at most
NO_MARKER, UNKNOWN = -1, -2  # what a point is that leaps, and what a label of nobody stands for


def judged_findings(
    truth: Mapping[str, np.ndarray], model: SubjectModel, rng: np.random.Generator
) -> Iterator[tuple[float, bool]]:
    """Evidence (nats) of each finding that can be judged, and whether it is right."""
    places, rate = places_of(truth), float(truth["rate"])
    points, real = planted(places, rate, rng)
    names = truth["labels"].tolist()
    place = {**{name: k for k, name in enumerate(names)}, None: NO_MARKER}
    for found in check(Recording(points, tuple(names), rate), model):
        frames = slice(found.first, found.last + 1)
        if not truth["judged"][frames, found.column].all():
            continue
        should_be = place.get(found.should_be, UNKNOWN)
        there = np.isfinite(points[frames, found.column]).all(-1)
        is_right = (real[frames, found.column] == should_be)[there]
        yield found.evidence, bool(is_right.mean() > 0.5)


def planted(
    places: Float[np.ndarray, "frames markers 3"], rate: float, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "frames markers 3"], Int[np.ndarray, "frames markers"]]:
    """The points with some pairs exchanged and some leaps, and which marker each column really shows or `NO_MARKER`."""
    points = places.copy()
    real = np.tile(np.arange(places.shape[1]), (len(places), 1))
    for _ in range(EXCHANGES):
        first, stop = _span(len(places), len(places), rng)
        one = int(rng.integers(places.shape[1]))
        other = _neighbour(places[(first + stop) // 2], one, rng)
        for each in (points, real):
            each[first:stop, [one, other]] = each[first:stop, [other, one]]
    for _ in range(LEAPS):
        first, stop = _span(len(places), max(1, round(LEAP_SECONDS * rate)), rng)
        column, way = int(rng.integers(places.shape[1])), rng.normal(size=3)
        points[first:stop, column] += rng.uniform(*LEAP_MM) * way / np.linalg.norm(way)
        real[first:stop, column] = NO_MARKER
    return points, real


def _span(frames: int, longest: int, rng: np.random.Generator) -> tuple[int, int]:
    """A half-open range of frames; short ones are as likely as long ones, by the logarithm."""
    length = min(frames, int(np.exp(rng.uniform(0.0, np.log(longest + 1)))))
    first = int(rng.integers(0, frames - length + 1))
    return first, first + length


def _neighbour(places: Float[np.ndarray, "markers 3"], one: int, rng: np.random.Generator) -> int:
    """Another marker, near by if that is known."""
    apart = np.linalg.norm(places - places[one], axis=-1)
    apart[one] = np.inf
    near = np.argsort(np.where(np.isfinite(apart), apart, 1e9), kind="stable")[:NEAREST]
    return int(rng.choice(near[near != one]))
