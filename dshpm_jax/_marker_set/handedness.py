"""Fours of markers whose signed volume tells a body from its mirror image."""

from collections.abc import Sequence

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
    each: Sequence[Sequence[Float[np.ndarray, "frames markers 3"]]], tuning: SetTuning
) -> tuple[HandedFour, ...]:
    """For each marker the fours that keep their volume best in all subjects, each once.

    Arguments:
        each: the clips of each subject, of the same markers.
    """
    markers = each[0][0].shape[1]
    if markers < 4:
        return ()
    fours = _drawn(markers, tuning)
    measured = [_measured(clips, fours, tuning) for clips in each]
    means, variances = (np.stack(values) for values in zip(*measured))
    known = np.isfinite(means)
    count = known.sum(0)
    mean = np.where(known, means, 0.0).sum(0) / np.maximum(count, 1)
    around = np.where(known, (means - mean) ** 2, 0.0).sum(0)
    inside = np.where(known, variances, 0.0).sum(0) / np.maximum(count, 1)
    between = (around + BETWEEN_FLOOR**2) / np.maximum(count - 1, 1)
    sd = np.sqrt(0.5 * inside + between + tuning.volume_noise**2)
    one_sign = np.all((np.sign(means) == np.sign(mean)) | ~known, axis=0) & (count >= min(2, len(each)))
    constancy = np.where(one_sign, np.abs(mean) / sd, 0.0)
    kept: set[int] = set()
    for marker in range(markers):
        own = np.flatnonzero((fours == marker).any(1) & (constancy > 0))
        kept |= set(own[np.argsort(-constancy[own], kind="stable")[: tuning.fours_kept]].tolist())
    return tuple(HandedFour(tuple(fours[k].tolist()), float(mean[k]), float(sd[k])) for k in sorted(kept))


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
