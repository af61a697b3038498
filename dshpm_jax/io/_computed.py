"""Points that a model computed from others, told by how exactly they follow them.

No measured point keeps its distance to another to the rounding of a file, or lies in the middle of two others: noise of
cameras alone is some hundredths of a millimetre. Solved rigid bodies do all keep their distances, so that alone tells
nothing: only copies, the ends of right-angled axes and fixed mixtures of points that move against each other do.
"""

import itertools

import numpy as np
from jaxtyping import Bool, Float

from dshpm_jax._geometry import every_nth, is_seen

EXACT_MM = 0.003
"""Millimetres; used throughout: the rounding of a file, and its square root of a sum, are below; noise is above."""

LEAST_FRAMES = 30
"""Frames; used in `computed_points`: fewer say too little."""

MOST_FRAMES = 100
"""Frames; used in `computed_points`: more say nothing new."""

SEEN_SHARE = 0.9
"""Of the frames; used in `computed_points`: columns that are seen less often are not judged."""

MOST_MIXED = 4
"""Points; used in `_is_mixture`: the mean of so many is met with, and more fit any point by chance."""

LEAST_WEIGHT = 0.05
"""No unit; used in `_is_mixture`: of a point that is mixed in."""

LEAST_MOTION_MM = 1.0
"""Millimetres; used for pairs and in `_is_mixture`: where points do not move so much against each other, that they keep
their places tells nothing, or they are parts of a solved rigid body."""

MOST_PARTNERS = 12
"""Points; used in `_axis_ends`: a body of more that keep their distances is a solved one, no axes."""


def computed_points(points: Float[np.ndarray, "frames points 3"]) -> Bool[np.ndarray, " points"]:
    """Which columns are copies, ends of axes or mixtures of others.

    Of two columns that are the same the first counts as measured, and so does the origin of axes.
    """
    seen = is_seen(points)
    found = np.zeros(points.shape[1], bool)
    columns = np.flatnonzero(seen.mean(0) >= SEEN_SHARE) if len(points) else np.zeros(0, int)
    frames = np.flatnonzero(seen[:, columns].all(1))
    if len(frames) < LEAST_FRAMES or len(columns) < 3:
        return found
    some = frames[every_nth(len(frames), MOST_FRAMES)]
    clip = points[np.ix_(some, columns)]
    spread, turned, mean = _distances(clip)
    copies = np.triu(mean < EXACT_MM, 1).any(0)
    apart = ~copies
    exact = (spread < EXACT_MM) & (turned > LEAST_MOTION_MM) & np.outer(apart, apart)
    out = copies | _axis_ends(clip, exact)
    rest = np.flatnonzero(~out)
    out[rest] = _mixtures(clip[:, rest], spread[np.ix_(rest, rest)])
    found[columns] = out
    return found


def _distances(clip: Float[np.ndarray, "frames points 3"]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How much the distances of all pairs change, how much they turn, and what they are on the average (mm)."""
    spread, turned, mean = (np.empty((clip.shape[1],) * 2) for _ in range(3))
    for k in range(clip.shape[1]):
        apart = clip - clip[:, k : k + 1]
        distance = np.linalg.norm(apart, axis=-1)
        spread[k], turned[k], mean[k] = distance.std(0), np.linalg.norm(apart.std(0), axis=-1), distance.mean(0)
    return spread, turned, mean


def _axis_ends(
    clip: Float[np.ndarray, "frames points 3"], exact: Bool[np.ndarray, "points points"]
) -> Bool[np.ndarray, " points"]:
    """Ends of three axes at right angles, which all keep their distances to their origin and to each other."""
    ends = np.zeros(clip.shape[1], bool)
    first = clip[0]
    partners = exact.sum(1)
    for origin in np.flatnonzero((partners >= 3) & (partners <= MOST_PARTNERS)):
        for three in itertools.combinations(np.flatnonzero(exact[origin]), 3):
            if exact[np.ix_(three, three)].sum() < 6:
                continue
            arms = first[list(three)] - first[origin]
            lengths = np.linalg.norm(arms, axis=1)
            cosines = (arms @ arms.T / np.outer(lengths, lengths))[np.triu_indices(3, 1)]
            if (np.abs(cosines) * lengths.max() < 10 * EXACT_MM).all():
                ends[list(three)] = True
    return ends


def _mixtures(
    clip: Float[np.ndarray, "frames points 3"], spread: Float[np.ndarray, "points points"]
) -> Bool[np.ndarray, " points"]:
    """Points that lie among a few others, always with the same weights."""
    found = np.zeros(clip.shape[1], bool)
    table = clip.transpose(0, 2, 1).reshape(-1, clip.shape[1])
    heavy = np.full((1, clip.shape[1]), 1e3)  # weights add up to one
    _, values, turned = np.linalg.svd(np.concatenate([table, heavy]), full_matrices=False)
    unlike = 1 / np.sqrt(((turned / np.maximum(values, 1e-6)[:, None]) ** 2).sum(0))  # what no others explain
    for point in np.flatnonzero(unlike / np.sqrt(len(table)) < EXACT_MM):
        found[point] = _is_mixture(np.concatenate([table, heavy]), int(point), spread, found)
    return found


def _is_mixture(
    table: Float[np.ndarray, "rows points"], point: int, spread: np.ndarray, out: Bool[np.ndarray, " points"]
) -> bool:
    """Whether the others, but those that are out, give a point exactly."""
    from scipy.optimize import nnls  # half of what a command takes to start, and few files have such a point

    others = np.flatnonzero(~out & (np.arange(table.shape[1]) != point))
    weights, _ = nnls(table[:, others], table[:, point])
    mixed = others[weights >= LEAST_WEIGHT]
    if not 2 <= len(mixed) <= MOST_MIXED or spread[np.ix_(mixed, mixed)].max() <= LEAST_MOTION_MM:
        return False
    _, residual = nnls(table[:, mixed], table[:, point])
    return bool(residual / np.sqrt(len(table)) < EXACT_MM)
