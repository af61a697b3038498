"""Labels given away one after the other: what leads out of a shift by one that distances alone do not mind.

A spine whose labels are shifted by one keeps nearly all of its distances; only signed volumes tell. So whole chains are
proposed by what distances say, and judged by both.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._types import NO_MATCH

LONGEST = 12
"""count; used in `chains`: labels that a chain gives away at most; by hand: a spine with a head has fewer."""

FIRST_LABELS = 2
"""count; used in `chains`: labels that each point tries first, besides its own; by hand: cost."""

MOST_DROPPED = 8
"""count; used in `drops`: labels that are taken away together at most; by hand."""

_Labels = Int[np.ndarray, " points"]
_Benefit = Float[np.ndarray, "points markers"]


def chains(labels: _Labels, benefit: _Benefit, unlabelled: float) -> Iterator[_Labels]:
    """Labellings after chains from every point, and from every free label."""
    said = benefit.copy()
    labelled = np.flatnonzero(labels != NO_MATCH)
    said[labelled, labels[labelled]] = -np.inf
    best = np.argsort(-said, axis=1, kind="stable")[:, :FIRST_LABELS]
    for point, wanted in enumerate(best):
        for label in wanted:
            yield _pushed(labels, benefit, unlabelled, point, int(label))
    for label in np.setdiff1d(np.arange(benefit.shape[1]), labels):
        yield from _pulled(labels, benefit, unlabelled, int(label))


def drops(labels: _Labels, without: Float[np.ndarray, " labelled"]) -> Iterator[_Labels]:
    """Labellings without the labels that say least, one, two and more of them.

    Arguments:
        without: what a labelling is worth without each of the labels, in the order of the labelled points.
    """
    labelled = np.flatnonzero(labels != NO_MATCH)
    dropped = labels.copy()
    for k in np.argsort(-without, kind="stable")[:MOST_DROPPED]:
        dropped = dropped.copy()
        dropped[labelled[k]] = NO_MATCH
        yield dropped


def _pushed(labels: _Labels, benefit: _Benefit, unlabelled: float, point: int, label: int) -> _Labels:
    """A point takes a label; whoever loses one takes its best other one, until that is free or none."""
    changed, used = labels.copy(), set()
    for _ in range(LONGEST):
        holder = np.flatnonzero(changed == label)
        changed[point] = label
        used.add(label)
        if not len(holder):
            return changed
        point = int(holder[0])
        changed[point] = NO_MATCH
        left = np.array([k for k in range(benefit.shape[1]) if k not in used])
        if not len(left) or benefit[point, left].max() < unlabelled:
            return changed
        label = int(left[benefit[point, left].argmax()])
    return changed


def _pulled(labels: _Labels, benefit: _Benefit, unlabelled: float, label: int) -> Iterator[_Labels]:
    """A free label goes to the point that it fits best, whose own goes on in the same way; after every step."""
    changed = labels.copy()
    own = np.where(labels == NO_MATCH, unlabelled, benefit[np.arange(len(labels)), np.maximum(labels, 0)])
    moved = np.zeros(len(labels), bool)
    for _ in range(LONGEST):
        gain = np.where(moved, -np.inf, benefit[:, label] - own)
        point = int(np.argmax(gain))
        free, changed[point], moved[point] = int(changed[point]), label, True
        yield changed.copy()
        if free == NO_MATCH or moved.all():
            return
        label = free
