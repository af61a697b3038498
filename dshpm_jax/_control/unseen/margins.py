"""By how much the population prefers a labelling to others that are near it, and which label it nearly took instead."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.unseen.judge import Judge
from dshpm_jax._control.unseen.search import near_labellings
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH

FAR = 100.0
"""nats; used in `Margins`: what no rival comes near is this much better; by hand: more makes no difference."""


@dataclass(frozen=True, eq=False)
class Margins:
    """How clear each label is.

    Attributes:
        nats: by how much the best labelling is better than the best one in which this label is elsewhere; NaN for a
            label that was not found.
        rival: the label that its point then has, `NO_MATCH` for none.
    """

    nats: Float[np.ndarray, " markers"]
    rival: Int[np.ndarray, " markers"]


def margins_of(
    judge: Judge, labels: Int[np.ndarray, " points"], permutations: Sequence[Int[np.ndarray, " markers"]]
) -> Control[Margins]:
    """The margins of the labels of one moment."""
    markers = len(judge.pairs.table)
    nats, rival = np.full(markers, np.nan), np.full(markers, NO_MATCH)
    labelled = labels != NO_MATCH
    nats[labels[labelled]] = FAR
    others = yield from near_labellings(judge, labels, permutations)
    if not len(others):
        return Margins(nats, rival)
    values = yield from judge.values(np.concatenate([labels[None], others]))
    for other, value in zip(others, values[1:], strict=True):
        changed = labelled & (other != labels)
        own, behind = labels[changed], values[0] - value
        nearer = behind < nats[own]
        nats[own[nearer]], rival[own[nearer]] = behind, other[changed][nearer]
    return Margins(nats, rival)


def together(each: Sequence[Margins]) -> Margins:
    """The mean margins over moments, and the rivals of the moments in which they are least."""
    nats = np.stack([one.nats for one in each])
    seen = np.isfinite(nats)
    mean = np.where(seen, nats, 0.0).sum(0) / np.maximum(seen.sum(0), 1)
    least = np.where(seen, nats, np.inf).argmin(0)
    rival = np.stack([one.rival for one in each])[least, np.arange(nats.shape[1])]
    return Margins(np.where(seen.any(0), mean, np.nan), rival)
