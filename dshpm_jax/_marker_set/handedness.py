"""Fours of markers whose signed volume tells a body from its mirror image."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._geometry import evenly_spaced
from dshpm_jax._marker_set.marker_set import HandedFour
from dshpm_jax._marker_set.tuning import SetTuning

SEED = 0
"""The same subjects give the same set."""

BETWEEN_FLOOR = 0.02
"""normalised volume; used in `handed_fours`: subjects differ by at least this; by hand."""


def signed_volumes(
    points: Float[np.ndarray, "frames markers 3"], fours: Int[np.ndarray, "fours 4"]
) -> Float[np.ndarray, "frames fours"]:
    """Volumes that fours of points span, over the product of the three edges at the first; from -1 to 1."""
    first = points[:, fours[:, 0]]
    a, b, c = (points[:, fours[:, k]] - first for k in (1, 2, 3))
    edges = np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1) * np.linalg.norm(c, axis=-1)
    return np.einsum("fqi,fqi->fq", a, np.cross(b, c)) / np.maximum(edges, 1e-9)


def handed_fours(
    each: Sequence[Sequence[Float[np.ndarray, "frames markers 3"]]],
    distance: Float[np.ndarray, "markers markers"],
    tuning: SetTuning,
) -> tuple[HandedFour, ...]:
    """For each marker, and for each two near ones, the fours that keep their volume best in all subjects, each once.

    Two near markers, such as those of a wrist, may have equal distances to all others; only a volume that both are part
    of changes its sign if they are exchanged.

    Arguments:
        each: the clips of each subject, of the same markers.
        distance: mean distances (mm), by which near markers are found.
    """
    markers = each[0][0].shape[1]
    if markers < 4:
        return ()
    near = _nearest(distance, tuning)
    fours = np.unique(np.sort(np.concatenate([_drawn(markers, tuning), _local(near)]), axis=1), axis=0)
    mean, sd, constancy = _judged([_measured(clips, fours, tuning) for clips in each], tuning)
    kept: set[int] = set()
    holds = np.zeros((len(fours), markers), bool)
    np.put_along_axis(holds, fours, True, axis=1)
    for marker in range(markers):
        kept |= _most_constant(holds[:, marker], constancy, tuning.fours_kept)
        for other in near[marker]:
            kept |= _most_constant(holds[:, marker] & holds[:, other], constancy, tuning.fours_of_pair)
    return tuple(HandedFour(tuple(fours[k].tolist()), float(mean[k]), float(sd[k])) for k in sorted(kept))


def _judged(
    measured: Sequence[tuple[np.ndarray, np.ndarray]], tuning: SetTuning
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean and standard deviation of each volume in a new subject, and how surely it keeps its sign."""
    means, variances = (np.stack(values) for values in zip(*measured))
    known = np.isfinite(means)
    count = known.sum(0)
    mean = np.where(known, means, 0.0).sum(0) / np.maximum(count, 1)
    around = np.where(known, (means - mean) ** 2, 0.0).sum(0)
    inside = np.where(known, variances, 0.0).sum(0) / np.maximum(count, 1)
    between = (around + BETWEEN_FLOOR**2) / np.maximum(count - 1, 1)
    sd = np.sqrt(0.5 * inside + between + tuning.volume_noise**2)
    one_sign = np.all((np.sign(means) == np.sign(mean)) | ~known, axis=0) & (count >= min(2, len(measured)))
    return mean, sd, np.where(one_sign, np.abs(mean) / sd, 0.0)


def _most_constant(which: np.ndarray, constancy: np.ndarray, count: int) -> set[int]:
    own = np.flatnonzero(which & (constancy > 0))
    return set(own[np.argsort(-constancy[own], kind="stable")[:count]].tolist())


def _nearest(distance: np.ndarray, tuning: SetTuning) -> Int[np.ndarray, "markers near"]:
    """For each marker those nearest to it."""
    apart = np.where(np.isfinite(distance), distance, np.inf)
    np.fill_diagonal(apart, np.inf)
    return np.argsort(apart, axis=1, kind="stable")[:, : min(tuning.fours_near, len(distance) - 1)]


def _local(near: Int[np.ndarray, "markers near"]) -> Int[np.ndarray, "fours 4"]:
    """All fours of a marker and three of those nearest to it."""
    three = np.array(list(combinations(range(near.shape[1]), 3)), int).reshape(-1, 3)
    own = np.repeat(np.arange(len(near)), len(three))
    return np.column_stack([own, near[:, three].reshape(-1, 3)])


def _drawn(markers: int, tuning: SetTuning) -> Int[np.ndarray, "fours 4"]:
    rng = np.random.default_rng(SEED)
    return np.argsort(rng.random((tuning.fours_drawn, markers)), axis=1, kind="stable")[:, :4]


def _measured(clips: Sequence[np.ndarray], fours: np.ndarray, tuning: SetTuning) -> tuple[np.ndarray, np.ndarray]:
    """Mean and variance of each volume over the clips of one subject, NaN where the four is never seen."""
    points = np.concatenate([clip[evenly_spaced(len(clip), tuning.fours_frames)] for clip in clips])
    volumes = signed_volumes(points[evenly_spaced(len(points), tuning.fours_frames)], fours)
    seen = np.isfinite(volumes)
    count = np.maximum(seen.sum(0), 1)
    mean = np.where(seen, volumes, 0.0).sum(0) / count
    variance = np.where(seen, (volumes - mean) ** 2, 0.0).sum(0) / count
    return np.where(seen.any(0), mean, np.nan), variance
