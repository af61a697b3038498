"""How far trajectories are from each other over the whole recording, whatever their labels."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._geometry import pair_distances
from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import NO_MATCH

FRAMES_AT_ONCE = 64  # whose tables of distances are held together


@dataclass(frozen=True, eq=False)
class PairSums:
    """Of the distances of all trajectories that share a sampled frame, each pair both ways, by the first of the two.

    Attributes:
        frames: number of sampled frames.
        one, other: the trajectories.
        sums: number of shared frames, sum of the distances (mm) and of their squares (mm^2).
        first: where the pairs of each trajectory begin, and where the last ones end.
    """

    frames: int
    one: Int[np.ndarray, " pairs"]
    other: Int[np.ndarray, " pairs"]
    sums: Float[np.ndarray, "3 pairs"]
    first: Int[np.ndarray, " trajectories+1"]

    @classmethod
    def of(cls, t: Trajectories, frames: Int[np.ndarray, " frames"]) -> "PairSums":
        parts = [_pairs_in(t, frames[k : k + FRAMES_AT_ONCE]) for k in range(0, max(len(frames), 1), FRAMES_AT_ONCE)]
        codes, apart = (np.concatenate(each) for each in zip(*parts, strict=True))
        code, place = np.unique(codes, return_inverse=True)
        sums = np.stack([np.bincount(place, each, len(code)) for each in (np.ones_like(apart), apart, apart**2)])
        one, other = np.divmod(code, max(len(t), 1))
        one, other = np.concatenate([one, other]), np.concatenate([other, one])
        order = np.argsort(one, kind="stable")
        first = np.searchsorted(one[order], np.arange(len(t) + 1))
        return cls(len(frames), one[order], other[order], np.tile(sums, 2)[:, order], first)

    def pairs_of(self, trajectories: Int[np.ndarray, " some"]) -> Int[np.ndarray, " pairs"]:
        """The pairs of which one of the trajectories is the first."""
        begin, size = self.first[trajectories], np.diff(self.first)[trajectories]
        place = np.arange(size.sum()) - np.repeat(np.cumsum(size) - size, size)
        return np.repeat(begin, size) + place


def _pairs_in(t: Trajectories, frames: Int[np.ndarray, " frames"]) -> tuple[np.ndarray, np.ndarray]:
    """Each pair of trajectories in each of the frames, as one number, the lower trajectory first; and how far apart."""
    index, apart = t.index[frames], pair_distances(t.points[frames])
    lower = (index[:, :, None] != NO_MATCH) & (index[:, :, None] < index[:, None])
    frame, one, other = np.nonzero(lower)
    return index[frame, one].astype(np.int64) * len(t) + index[frame, other], apart[lower]
