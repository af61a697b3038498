"""How complete a labelling is, by the points that are there to be labelled."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Int

from dshpm_jax._labelling import Labelling, Reason
from dshpm_jax._types import NO_MATCH

LONG_SECONDS = 1.0
"""Seconds; used in `_may_be_unseen`: gaps and false points are mostly shorter, markers that nobody found are not."""


@dataclass(frozen=True, eq=False)
class Lives:
    """What completeness needs to know of a labelling; a sidecar says it as well as the labelling itself.

    Attributes:
        markers: names of the model's markers.
        frames, long: frames of the recording, and of `LONG_SECONDS`, but at most half of the recording.
        start, stop: for each trajectory its half-open range of frames.
        identity: for each trajectory its marker, or `NO_MATCH`.
        could_be: for each trajectory the markers that it may be, besides its label; `NO_MATCH` beyond.
        outside: for each trajectory whether there is evidence that it is none of the markers whose place is known.
        none: for each trajectory whether it is known to be no marker.
    """

    markers: tuple[str, ...]
    frames: int
    long: int
    start: Int[np.ndarray, " trajectories"]
    stop: Int[np.ndarray, " trajectories"]
    identity: Int[np.ndarray, " trajectories"]
    could_be: Int[np.ndarray, "trajectories 2"]
    outside: Bool[np.ndarray, " trajectories"]
    none: Bool[np.ndarray, " trajectories"]

    @classmethod
    def of(cls, labelling: Labelling) -> "Lives":
        tracks, markers = labelling.trajectories, tuple(labelling.model.markers)
        none = np.full((len(tracks), 2), NO_MATCH)
        reasons = [str(reason) for reason in labelling.reason]
        return cls(
            markers,
            tracks.num_frames,
            _long(tracks.num_frames, tracks.rate),
            tracks.start,
            tracks.stop,
            labelling.identity,
            none if labelling.could_be is None else labelling.could_be,
            _outside(reasons, labelling.stats),
            _known(reasons) & (labelling.identity == NO_MATCH),
        )

    @classmethod
    def of_sidecar(cls, sidecar: Mapping[str, Any]) -> "Lives":
        """The same from what `io.read_sidecar` gives."""
        rows, markers = sidecar["trajectories"], tuple(sidecar["markers"])
        number = {None: NO_MATCH, **{marker: k for k, marker in enumerate(markers)}}
        others = [[number[name] for name in row.get("could_be", ())] for row in rows]
        frames = np.array([row["frames"] for row in rows], dtype=int).reshape(-1, 2)
        return cls(
            markers,
            sidecar["frames"],
            _long(sidecar["frames"], sidecar["rate"]),
            frames[:, 0],
            frames[:, 1] + 1,
            np.array([number[row["label"]] for row in rows], dtype=int),
            np.array([[*some, NO_MATCH, NO_MATCH][:2] for some in others], dtype=int).reshape(-1, 2),
            _outside([row["reason"] for row in rows], sidecar.get("stats", {})),
            _known([row["reason"] for row in rows]) & np.array([row["label"] is None for row in rows], dtype=bool),
        )


def completeness(lives: Lives) -> float:
    """The share of the points that are there to be labelled that got a label, 0 to 1.

    Labelled points, over these and the points that were missed. An unlabelled point was missed where a marker that it
    may be has no point in that frame:

    - where the labelling names markers that it may be (a label was withheld, or went to another trajectory), one of
      these;
    - where the evidence says that it lies where no marker is expected, a marker whose place is not known: one that has
      not been seen for a second before that frame, nor is for a second after it. A trajectory that is shorter counts
      as a false point;
    - else, as the paper's methods have no such evidence, any marker.

    A point that is known to be no marker was not missed. A frame has missed no more points than there are markers
    without one. So a gap is no loss, nor is a frame in which nobody is there, a marker that is not worn, or a false
    point beside a marker that is labelled. Nothing is complete where nothing is labelled.
    """
    labelled = lives.identity != NO_MATCH
    found = int((lives.stop - lives.start)[labelled].sum())
    if not found:
        return 0.0
    missing = ~_seen(lives)
    frame, which = _points(lives, np.flatnonzero(~labelled & ~lives.none))
    missed = _may_be(lives, missing, frame, which)
    lost = np.minimum(np.bincount(frame[missed], minlength=lives.frames), missing.sum(1)).sum()
    return math.floor(1e4 * found / (found + int(lost))) / 1e4


def never_seen(lives: Lives) -> list[str]:
    """The markers of the model that no trajectory is called."""
    found = set(lives.identity.tolist())
    return [name for k, name in enumerate(lives.markers) if k not in found]


def percent(share: float) -> str:
    """Only what is whole reads 100 %."""
    return f"{math.floor(1000 * share + 1e-6) / 10:.1f}%"


def _long(frames: int, rate: float) -> int:
    return max(1, min(round(LONG_SECONDS * rate), frames // 2))


def _outside(reasons: list[str], stats: Mapping[str, Any]) -> Bool[np.ndarray, " trajectories"]:
    """Only the full method, which says how well the model fits, has evidence; others call outside what is left."""
    found = np.array([reason in (str(Reason.OUTSIDE), str(Reason.TAKEN)) for reason in reasons], dtype=bool)
    return found & ("model_fit" in stats)


def _known(reasons: list[str]) -> Bool[np.ndarray, " trajectories"]:
    return np.array([reason == str(Reason.KNOWN) for reason in reasons], dtype=bool)


def _seen(lives: Lives) -> Bool[np.ndarray, "frames markers"]:
    """Which markers have a point in each frame."""
    change = np.zeros((lives.frames + 1, len(lives.markers)), np.int32)
    labelled = np.flatnonzero(lives.identity != NO_MATCH)
    np.add.at(change, (lives.start[labelled], lives.identity[labelled]), 1)
    np.add.at(change, (lives.stop[labelled], lives.identity[labelled]), -1)
    return change.cumsum(0)[:-1] > 0


def _points(lives: Lives, which: np.ndarray) -> tuple[Int[np.ndarray, " points"], Int[np.ndarray, " points"]]:
    """The frame and the trajectory of each point of some trajectories."""
    length = (lives.stop - lives.start)[which]
    ends = length.cumsum()
    since = np.arange(length.sum()) - np.repeat(ends - length, length)
    return np.repeat(lives.start[which], length) + since, np.repeat(which, length)


def _may_be(
    lives: Lives, missing: Bool[np.ndarray, "frames markers"], frame: np.ndarray, which: np.ndarray
) -> Bool[np.ndarray, " points"]:
    """Whether each point may be a marker that has no point in its frame."""
    without = np.append(missing, np.zeros((lives.frames, 1), bool), axis=1)  # NO_MATCH is -1: the last column
    known = np.any(lives.could_be != NO_MATCH, axis=1)
    named = without[frame[:, None], lives.could_be[which]].any(1)
    other = np.where(lives.outside[which], _may_be_unseen(lives, missing)[frame], np.any(missing, axis=1)[frame])
    other &= ~lives.outside[which] | (lives.stop - lives.start >= lives.long)[which]
    return np.where(known[which], named, other)


def _may_be_unseen(lives: Lives, missing: Bool[np.ndarray, "frames markers"]) -> Bool[np.ndarray, " frames"]:
    """In which frames there is a marker whose place is not known, as it is not seen for long before and after."""
    sights = np.append(np.zeros((1, missing.shape[1]), int), (~missing).cumsum(0), axis=0)
    frames = np.arange(lives.frames)
    first, last = np.maximum(frames - lives.long, 0), np.minimum(frames + lives.long + 1, lives.frames)
    return (sights[last] == sights[first]).any(1)
