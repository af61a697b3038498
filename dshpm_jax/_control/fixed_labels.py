"""Labels that are given and that nothing overrules: what they forbid all others."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import NO_MATCH, UNKNOWN

CLOSED_LLR = -1e4
"""Nats; used in `FixedLabels.llr`: for a label that a trajectory cannot get; derived: less than any evidence is."""


@dataclass(frozen=True, eq=False)
class FixedLabels:
    """The labels that some trajectories have whatever the evidence says.

    Attributes:
        identity: the marker of each trajectory, `NO_MATCH` where it is none for certain, `UNKNOWN` where nobody said.
        given: whose label is given.
        open: which labels each may get: of those given its own alone, else all that none holds which shares a frame.
    """

    identity: Int[np.ndarray, " trajectories"]
    given: Bool[np.ndarray, " trajectories"]
    open: Bool[np.ndarray, "trajectories markers"] | None

    @classmethod
    def of(cls, t: Trajectories, identity: Int[np.ndarray, " trajectories"], markers: int) -> "FixedLabels":
        """Those of trajectories `t`, with so many markers in the model."""
        given = identity != UNKNOWN
        if not given.any():
            return cls(identity, given, None)
        free = np.ones((len(t), markers), bool)
        for j in np.flatnonzero(identity >= 0):
            free[(t.start < t.stop[j]) & (t.start[j] < t.stop), identity[j]] = False
        free[given] = False
        named = np.flatnonzero(identity >= 0)
        free[named, identity[named]] = True
        return cls(identity, given, free)

    @classmethod
    def none(cls, t: Trajectories) -> "FixedLabels":
        """No label of any trajectory is given."""
        return cls(np.full(len(t), UNKNOWN, np.int32), np.zeros(len(t), bool), None)

    def on(self, identity: Int[np.ndarray, " trajectories"]) -> Int[np.ndarray, " trajectories"]:
        """The labels with those given in their places, and without those that these leave no room for."""
        if self.open is None:
            return identity
        allowed = self.open[np.arange(len(identity)), np.maximum(identity, 0)]
        left = np.where(allowed, identity, NO_MATCH)
        return np.where(self.given, self.identity, left).astype(identity.dtype)

    def llr(self, llr: Float[np.ndarray, "trajectories markers"]) -> Float[np.ndarray, "trajectories markers"]:
        """The evidence with `CLOSED_LLR` for every label that a trajectory cannot get."""
        return llr if self.open is None else np.where(self.open, llr, CLOSED_LLR)


def fix(
    t: Trajectories, points: Int[np.ndarray, "frames columns"]
) -> tuple[Trajectories, Int[np.ndarray, " trajectories"], Int[np.ndarray, " trajectories"]]:
    """Trajectories cut where what is known of their points changes, what is known of each, and its whole before.

    Arguments:
        points: for each point of the recording what is known of it, see `_known.known_points`.
    """
    frame, slot = np.nonzero(t.index != NO_MATCH)
    order = np.lexsort((frame, t.index[frame, slot]))
    frame, slot = frame[order], slot[order]
    which, label = t.index[frame, slot], points[frame, t.column[frame, slot]]
    changes = np.flatnonzero((np.diff(which) == 0) & (np.diff(label) != 0)) + 1
    whole = np.arange(len(t))
    if len(changes):
        t, whole = t.cut(which[changes], frame[changes])
    slots = t.slot
    return t, points[t.start, t.column[t.start, slots]].astype(np.int32), whole
