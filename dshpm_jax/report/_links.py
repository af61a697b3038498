"""Which markers have a stick between them on a page."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from dshpm_jax._geometry import evenly_spaced, is_seen, pair_distances
from dshpm_jax.report._looks import shortest_tree

SAMPLED_FRAMES = 200  # in which distances between markers are measured
SOFT = 0.15  # markers whose distance varies by more than this share of it are not linked, unless a segment says so
REACH = 0.35  # of a subject's size: parts that lie further apart are not linked

Link = tuple[int, int, int]
"""Two columns, and the part that the stick belongs to (-1: none)."""


@dataclass(frozen=True)
class Part:
    """A segment on the page: its name and the columns of its markers."""

    name: str
    columns: tuple[int, ...]


def links_of(points: Float[np.ndarray, "frames markers 3"], parts: Sequence[Part], names: Sequence[str]) -> list[Link]:
    """Within each part the shortest tree, and parts that share no marker linked, as a head is to the trunk.

    Without parts a tree of the nearest and most rigid pairs of all markers.
    """
    sample = points[evenly_spaced(len(points), SAMPLED_FRAMES)]
    mean, spread = _distances(sample)
    if not parts:
        return [(i, j, -1) for i, j in shortest_tree(_stiff(mean, spread))]
    found = []
    for p, part in enumerate(parts):
        own = list(part.columns)
        found += [(own[i], own[j], p) for i, j in shortest_tree(mean[np.ix_(own, own)])]
    costs = np.where(_near(mean, names), _stiff(mean, spread), np.inf)
    return [*found, *_between(found, costs, parts)]


def _near(mean: Float[np.ndarray, "n n"], names: Sequence[str]) -> Bool[np.ndarray, "n n"]:
    """Which markers are of the same subject and close to each other, for the size of the subject."""
    subject = np.array([name.rpartition(":")[0] for name in names])
    same = subject[:, None] == subject
    reach = np.where(same & np.isfinite(mean), mean, 0.0).max(1, initial=0.0)  # from each marker
    size = np.where(same, reach, 0.0).max(1, initial=0.0)  # of its subject
    return same & (mean <= REACH * size)


def _between(links: Sequence[Link], costs: Float[np.ndarray, "n n"], parts: Sequence[Part]) -> list[Link]:
    """The least costly links that join what is linked so far; each belongs to the later part."""
    n = len(costs)
    ends = np.array([link[:2] for link in links], int).reshape(-1, 2)
    _, group = connected_components(coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n, n)), False)
    part_of = {column: p for p, part in reversed(list(enumerate(parts))) for column in part.columns}
    best: dict[tuple[int, int], tuple[int, int]] = {}
    for i, j in sorted(zip(*np.nonzero(np.isfinite(costs)), strict=True), key=lambda pair: costs[pair]):
        if i < j and group[i] != group[j] and i in part_of and j in part_of:
            best.setdefault((min(group[i], group[j]), max(group[i], group[j])), (int(i), int(j)))
    groups = int(group.max(initial=-1)) + 1
    between = np.full((groups, groups), np.inf)
    for pair, (i, j) in best.items():
        between[pair] = between[pair[::-1]] = costs[i, j]
    chosen = [best[min(pair), max(pair)] for pair in shortest_tree(between)]
    return [(i, j, max(part_of[i], part_of[j])) for i, j in chosen]


def _stiff(mean: Float[np.ndarray, "n n"], spread: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "n n"]:
    """What a link between two markers costs: near ones whose distance hardly changes are best; infinite beyond."""
    with np.errstate(invalid="ignore"):
        return np.where(spread < SOFT * mean, mean + 4 * spread, np.inf)


def _distances(points: Float[np.ndarray, "frames n 3"]) -> tuple[Float[np.ndarray, "n n"], Float[np.ndarray, "n n"]]:
    """Mean and spread of all distances (mm), infinite for pairs never seen together."""
    both = is_seen(points)
    count = both.T.astype(float) @ both
    mean, square = np.zeros(count.shape), np.zeros(count.shape)
    for frame in np.where(both[..., None], points, np.nan):
        distance = np.nan_to_num(pair_distances(frame))
        mean, square = mean + distance, square + distance**2
    mean, square = mean / np.maximum(count, 1), square / np.maximum(count, 1)
    seen = count > 0
    return np.where(seen, mean, np.inf), np.where(seen, np.sqrt(np.maximum(square - mean**2, 0)), np.inf)
