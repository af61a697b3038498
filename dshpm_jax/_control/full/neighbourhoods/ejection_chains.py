"""Ejection chains: an unlabelled trajectory takes a label; who held it goes without, elsewhere, or ejects the next.

A long recording has hundreds of thousands of takes, of which a hundred are tried. So all are followed side by side, as
numbers, and only the most promising are written out as moves.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._control.full.moves import Move
from dshpm_jax._control.tuning import Tuning
from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import NO_MATCH

AT_ONCE = 4096  # takes followed side by side; more need more memory


def propose_takes(
    t: Trajectories, identity: Int[np.ndarray, " trajectories"], llr: np.ndarray, tuning: Tuning
) -> Iterator[Move]:
    """The `max_moves` most promising takes, among some others.

    Arguments:
        llr: mean ratio of each label for each trajectory (nats).
    """
    count = tuning.max_moves
    carriers = _Carriers.of(t, identity)
    taker, label = _tried(identity, llr, tuning)
    for first in range(0, len(taker), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        steps = list(_followed(carriers, identity, llr, taker[some], label[some], tuning))
        promise = np.concatenate([step.promise for step in steps])
        least = np.partition(promise, -count)[-count] if count < len(promise) else -np.inf
        for depth, step in enumerate(steps):
            for take in step.take[step.promise >= least].tolist():
                yield _written(steps[: depth + 1], take, int(taker[first + take]))
        for take in np.flatnonzero(steps[0].promise >= least).tolist():
            yield from _elsewhere(carriers, llr, steps[0], take, int(taker[first + take]), tuning.min_take_llr)


def _tried(identity: np.ndarray, llr: np.ndarray, tuning: Tuning) -> tuple[np.ndarray, np.ndarray]:
    """The unlabelled trajectories, each with every label that it tries to take."""
    free = np.flatnonzero((identity == NO_MATCH) & (llr.max(1, initial=-np.inf) > tuning.min_take_llr))
    label = np.argsort(-llr[free], axis=1, kind="stable")[:, : tuning.labels_tried]
    tries = np.take_along_axis(llr[free], label, axis=1) > tuning.min_take_llr
    return np.broadcast_to(free[:, None], label.shape)[tries], label[tries]


class _Step(NamedTuple):
    """What becomes of many takes with the label that is taken in this step, in place of the steps before.

    Attributes:
        take: which of the takes come so far, ascending.
        label: the label that is taken.
        gained: evidence gained up to here (nats).
        promise: the same, less what the displaced lose that go without.
        row, displaced: who is displaced, in which row of `take`; rows ascend, and trajectories in a row.
    """

    take: Int[np.ndarray, " takes"]
    label: Int[np.ndarray, " takes"]
    gained: Float[np.ndarray, " takes"]
    promise: Float[np.ndarray, " takes"]
    row: Int[np.ndarray, " displaced"]
    displaced: Int[np.ndarray, " displaced"]


def _followed(
    carriers: "_Carriers", identity: np.ndarray, llr: np.ndarray, taker: np.ndarray, label: np.ndarray, tuning: Tuning
) -> Iterator[_Step]:
    """The takes themselves, then each as it is passed on.

    The displaced take their next best label from whoever holds that, and so on. A real point beside a limb that belongs
    to no marker can shift all labels of the limb by one.
    """
    row, displaced = carriers.beside(label, np.arange(len(taker)), taker)
    gained = llr[taker, label]
    step = _Step(np.arange(len(taker)), label, gained, gained - _summed(llr, row, displaced, label), row, displaced)
    yield step
    taken = np.zeros((len(taker), llr.shape[1]), bool)
    for _ in range(tuning.max_chain_length):
        taken[step.take, step.label] = True
        step = _passed_on(carriers, identity, llr, taken, step, tuning.min_take_llr)
        if not len(step.take):
            return
        yield step


def _passed_on(
    carriers: "_Carriers",
    identity: np.ndarray,
    llr: np.ndarray,
    taken: Bool[np.ndarray, "takes markers"],
    step: _Step,
    least: float,
) -> _Step:
    """The displaced of a step take their next best label."""
    some, first, count = np.unique(step.row, return_index=True, return_counts=True)
    scores = np.add.reduceat(llr[step.displaced], first, axis=0) / count[:, None] if len(some) else llr[:0]
    scores[taken[step.take[some]]] = -np.inf
    label = scores.argmax(1)
    goes_on = np.take_along_axis(scores, label[:, None], axis=1)[:, 0] > least
    movers = np.repeat(goes_on, count)
    moved, label = step.displaced[movers], label[goes_on]
    row = np.repeat(np.arange(len(label)), count[goes_on])
    change = llr[moved, label[row]] - llr[moved, identity[moved]]
    gained = step.gained[some[goes_on]] + np.bincount(row, change, minlength=len(label))
    row, displaced = carriers.beside(label, row, moved)
    promise = gained - _summed(llr, row, displaced, label)
    return _Step(step.take[some[goes_on]], label, gained, promise, row, displaced)


def _summed(llr: np.ndarray, row: np.ndarray, displaced: np.ndarray, label: np.ndarray) -> np.ndarray:
    """The evidence of each row's label for those whom it displaces."""
    return np.bincount(row, llr[displaced, label[row]], minlength=len(label))


def _written(steps: list[_Step], take: int, taker: int) -> Move:
    """A take after the last of `steps`, in which the displaced go without."""
    changed, labels, promise = [np.array([taker])], [], 0.0
    for step in steps:
        row = int(np.searchsorted(step.take, take))
        labels.append(np.full(len(changed[-1]), step.label[row]))
        changed.append(step.displaced[step.row == row])
        promise = float(step.promise[row])
    labels.append(np.full(len(changed[-1]), NO_MATCH))
    return Move(np.concatenate(changed), np.concatenate(labels), promise)


def _elsewhere(
    carriers: "_Carriers", llr: np.ndarray, step: _Step, take: int, taker: int, least: float
) -> Iterator[Move]:
    """A take in which each of the displaced gets the best label that is free for it."""
    displaced, label = step.displaced[step.row == take], int(step.label[take])
    if len(displaced):
        free = [_best_free(carriers, llr, int(k), label, least) for k in displaced]
        yield Move(np.append(displaced, taker), np.array([*free, label]), float(step.promise[take]))


def _best_free(carriers: "_Carriers", llr: np.ndarray, trajectory: int, but: int, least: float) -> int:
    scores = llr[trajectory].copy()
    scores[carriers.labels_beside(trajectory)] = -np.inf
    scores[but] = -np.inf
    best = int(np.argmax(scores))
    return best if scores[best] > least else NO_MATCH


@dataclass(frozen=True)
class _Carriers:
    """Who carries which label when, on one line of time: a recording's length for each label.

    Attributes:
        t: the trajectories.
        who: the labelled ones by label and start.
        label: their labels.
        start, until: on the line, where each begins, and where all of its label that begin before it are over.
        span: the length of the line for a label.
    """

    t: Trajectories
    who: np.ndarray
    label: np.ndarray
    start: np.ndarray
    until: np.ndarray
    span: int

    @classmethod
    def of(cls, t: Trajectories, identity: np.ndarray) -> "_Carriers":
        named = np.flatnonzero(identity != NO_MATCH)
        who = named[np.lexsort((t.start[named], identity[named]))]
        label, span = identity[who].astype(int), t.num_frames + 1
        until = np.maximum.accumulate(label * span + t.stop[who])
        return cls(t, who, label, label * span + t.start[who], until, span)

    def beside(self, label: np.ndarray, row: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For each row the trajectories that carry its label while one of its `others` lives.

        Returns the rows, ascending, and trajectories, ascending in a row.
        """
        t, line = self.t, label[row] * self.span
        first = np.searchsorted(self.until, line + t.start[others], "right")
        last = np.maximum(np.searchsorted(self.start, line + t.stop[others], "left"), first)
        count = last - first
        place = np.repeat(last - np.cumsum(count), count) + np.arange(count.sum())
        carrier, row = self.who[place], np.repeat(row, count)
        meet = t.stop[carrier] > np.repeat(t.start[others], count)
        found = np.unique(row[meet] * len(t) + carrier[meet])
        return found // len(t), found % len(t)

    def labels_beside(self, trajectory: int) -> np.ndarray:
        """The labels that others carry while a trajectory lives."""
        t = self.t
        meet = (t.start[self.who] < t.stop[trajectory]) & (t.start[trajectory] < t.stop[self.who])
        return self.label[meet & (self.who != trajectory)]
