"""Trajectories: unbroken paths of single observed points, packed into few slots."""

import heapq
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._geometry import is_seen
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True, eq=False)
class Trajectories:
    """All trajectories of a recording, each an unbroken run of frames.

    A long recording has thousands of trajectories but only some hundred points in any one frame, so trajectories
    whose lives do not overlap share a *slot*: the point of trajectory `j` in frame `t` is `points[t, slot[j]]` for
    `start[j] <= t < stop[j]`.

    Attributes:
        points: positions in millimetres, NaN where a slot is empty.
        index: the trajectory in each slot, `NO_MATCH` where empty.
        column: the column of the recording in which each point stands, `NO_MATCH` where empty.
        slot, start, stop: for each trajectory, where it is and its half-open range of frames.
        rate: frames a second (Hz).
    """

    points: Float[np.ndarray, "frames slots 3"]
    index: Int[np.ndarray, "frames slots"]
    column: Int[np.ndarray, "frames slots"]
    slot: Int[np.ndarray, "trajectories"]
    start: Int[np.ndarray, "trajectories"]
    stop: Int[np.ndarray, "trajectories"]
    rate: float

    def __len__(self) -> int:
        return len(self.slot)

    @property
    def num_frames(self) -> int:
        return self.points.shape[0]

    def alive(self, frame: int) -> Bool[np.ndarray, "trajectories"]:
        """Which trajectories have a point in `frame`."""
        return (self.start <= frame) & (frame < self.stop)

    def at(self, frame: int) -> tuple[Int[np.ndarray, "points"], Float[np.ndarray, "points 3"]]:
        """The trajectories seen in `frame`, in ascending order, and their positions in millimetres."""
        here = np.flatnonzero(self.alive(frame))
        return here, self.points[frame, self.slot[here]]

    def single(self, frame: int) -> tuple[Int[np.ndarray, " points"], "Trajectories"]:
        """The trajectories seen in `frame`, and that frame alone as a recording of its own."""
        here, points = self.at(frame)
        return here, from_columns(points[None], self.rate)

    def between(self, first: int, last: int) -> tuple["Trajectories", Int[np.ndarray, " some"]]:
        """The trajectories seen in frames `first <= t < last`, as a recording of its own, and which they are."""
        which = np.flatnonzero((self.start < last) & (first < self.stop))
        number = np.full(len(self) + 1, NO_MATCH, self.index.dtype)  # NO_MATCH is -1: the last
        number[which] = np.arange(len(which))
        start, stop = np.maximum(self.start[which] - first, 0), np.minimum(self.stop[which], last) - first
        rows = slice(first, last)
        index, slot = number[self.index[rows]], self.slot[which]
        return Trajectories(self.points[rows], index, self.column[rows], slot, start, stop, self.rate), which

    def cut(
        self, which: Int[np.ndarray, " cuts"], frame: Int[np.ndarray, " cuts"]
    ) -> tuple["Trajectories", Int[np.ndarray, " trajectories"]]:
        """The same points with some trajectories cut before a frame, and for each new one which it was part of."""
        source = np.concatenate([np.arange(len(self)), which])
        start = np.concatenate([self.start, frame])
        order = np.lexsort((start, source))
        ends = np.append(start[order][1:], 0)
        stop = np.empty_like(start)
        stop[order] = np.where(np.append(np.diff(source[order]) == 0, False), ends, self.stop[source[order]])
        order = np.lexsort((source, start))  # numbered by first frame, as ever
        start, stop, source = start[order], stop[order], source[order]
        index = np.full_like(self.index, NO_MATCH)
        for k, (first, end, slot) in enumerate(zip(start, stop, self.slot[source])):
            index[first:end, slot] = k
        return Trajectories(self.points, index, self.column, self.slot[source], start, stop, self.rate), source

    def by_column(self, each: Int[np.ndarray, " trajectories"], columns: int) -> Int[np.ndarray, "frames columns"]:
        """What `each` says of the trajectory of every point of the recording, `NO_MATCH` where there is no point."""
        found = np.full((self.num_frames, columns), NO_MATCH, dtype=each.dtype)
        frame, slot = np.nonzero(self.index != NO_MATCH)
        found[frame, self.column[frame, slot]] = each[self.index[frame, slot]]
        return found

    def positions(self, frames: Int[np.ndarray, "n"], which: Int[np.ndarray, "k"]) -> Float[np.ndarray, "n k 3"]:
        """Positions of trajectories `which` in `frames` (millimetres), NaN outside their lives or for `NO_MATCH`."""
        frames, which = np.asarray(frames), np.asarray(which)
        found = self.points[frames[:, None], self.slot[which]]
        inside = (self.start[which] <= frames[:, None]) & (frames[:, None] < self.stop[which]) & (which != NO_MATCH)
        return np.where(inside[..., None], found, np.nan)


def by_marker(
    points: Float[np.ndarray, "*frames points 3"], identities: Int[np.ndarray, "*frames points"], markers: int
) -> Float[np.ndarray, "*frames markers 3"]:
    """The place of each marker (mm), NaN where no point carries it."""
    places = np.full((*points.shape[:-2], markers, 3), np.nan)
    named = np.nonzero(identities != NO_MATCH)
    places[*named[:-1], identities[named]] = points[named]
    return places


def from_columns(
    points: Float[np.ndarray, "frames points 3"],
    rate: float,
    links: Int[np.ndarray, "frames points"] | None = None,
) -> Trajectories:
    """Packs points into trajectories.

    Arguments:
        points: positions in millimetres, NaN where missing.
        rate: frames a second.
        links: for each point, the column in the *next* frame that continues it, or `NO_MATCH` where its path ends;
            by default a column continues itself for as long as it is seen (a gap ends a trajectory).

    Trajectories are numbered by first frame, then by place in it (x, y, z): the order of the columns, which means
    nothing, cannot reach any result.
    """
    points = np.asarray(points, dtype=np.float64)
    frames = len(points)
    at_frame, at_column = np.nonzero(is_seen(points))
    ahead = at_column if links is None else links[at_frame, at_column]
    which, head = _numbered(points, at_frame, at_column, ahead)
    start = at_frame[head]
    stop = np.zeros(len(head), dtype=int)
    np.maximum.at(stop, which, at_frame + 1)
    slot = _pack(start, stop)
    slots = int(slot.max()) + 1 if len(slot) else 0
    packed = np.full((frames, slots, 3), np.nan)
    packed[at_frame, slot[which]] = points[at_frame, at_column]
    packed_index = np.full((frames, slots), NO_MATCH, dtype=np.int32)
    packed_index[at_frame, slot[which]] = which
    column = np.full((frames, slots), NO_MATCH, dtype=np.int32)
    column[at_frame, slot[which]] = at_column
    return Trajectories(packed, packed_index, column, slot, start, stop, rate)


def _numbered(
    points: np.ndarray, frame: np.ndarray, column: np.ndarray, links: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The trajectory of each point seen, and the first point of each trajectory.

    Arguments:
        frame, column: where the points stand, in that order.
        links: the column in the next frame that continues each, `NO_MATCH` where its path ends; so does it where
            that column is empty.
    """
    width = points.shape[1]
    place, linked = frame * width + column, np.flatnonzero(links != NO_MATCH)
    target = (frame[linked] + 1) * width + links[linked]
    following = np.searchsorted(place, target)
    there = np.append(place, NO_MATCH)[following] == target
    before = np.arange(len(frame))  # the point that each continues, or itself
    before[following[there]] = linked[there]
    head = np.flatnonzero(before == np.arange(len(frame)))
    head = head[np.lexsort((*points[frame[head], column[head]].T[::-1], frame[head]))]
    number = np.empty(len(frame), np.int32)
    number[head] = np.arange(len(head))
    farther = before[before]
    while (farther != before).any():  # twice as far back each time, until all are at their heads
        before, farther = farther, farther[farther]
    return number[before], head


def _pack(start: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """The lowest free slot for each trajectory, in order of their first frames."""
    slot = np.zeros(len(start), dtype=int)
    free: list[int] = []
    busy: list[tuple[int, int]] = []
    used = 0
    for j in range(len(start)):
        while busy and busy[0][0] <= start[j]:
            heapq.heappush(free, heapq.heappop(busy)[1])
        if free:
            slot[j] = heapq.heappop(free)
        else:
            slot[j], used = used, used + 1
        heapq.heappush(busy, (int(stop[j]), int(slot[j])))
    return slot
