"""The driver: gathers what many controls ask for, answers it in few kernel calls.

A control is a generator that yields requests (`_requests`). The driver runs many of them, takes the requests that are
waiting, groups those of one kind and bucket, pads them to a few shapes, calls a jitted kernel once a group and sends
each its answer. An answer never depends on who shared the batch.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from typing import Any

from dshpm_jax._driver.buckets import COLUMN_BUCKETS, POINT_BUCKETS, SLOT_BUCKETS, bucket
from dshpm_jax._driver.evidence import life_evidences
from dshpm_jax._driver.fitting import fit
from dshpm_jax._driver.matching import match, score
from dshpm_jax._driver.segmentation import segment
from dshpm_jax._requests import Control, FitPoses, LifeEvidence, MatchSegment, ScoreMatch, Segmentation, Together
from dshpm_jax._scoring import (
    AbstractCandidateScore,
    AbstractMatchScore,
    MeanResidual,
    ToleranceScore,
    check_candidate_score,
    check_match_score,
)


class Driver:
    """Runs controls over the kernels.

    Arguments:
        candidate_score: how badly a candidate fits its column (Eq. 3).
        match_score: how badly a match fits its segment (Eq. 4).
            Both are tried on plausible numbers first; a `ValueError` names one that fails or answers with NaN.
        in_flight: controls that run at the same time; more make fuller batches and take more memory.
    """

    def __init__(
        self,
        candidate_score: AbstractCandidateScore | None = None,
        match_score: AbstractMatchScore | None = None,
        in_flight: int = 64,
    ):
        if candidate_score is not None:
            check_candidate_score(candidate_score)
        if match_score is not None:
            check_match_score(match_score)
        self._candidate_score = ToleranceScore() if candidate_score is None else candidate_score
        self._match_score = MeanResidual() if match_score is None else match_score
        self._in_flight = in_flight

    def run(self, controls: Iterable[Control]) -> Iterator[Any]:
        """The results of `controls`, in their order, each as soon as it and those before it are done."""
        waiting = iter(controls)
        done: dict[int, Any] = {}
        threads: dict[int, _Thread] = {}
        started = following = 0
        exhausted = False
        while True:
            while not exhausted and len(threads) < self._in_flight:
                control = next(waiting, None)
                if control is None:
                    exhausted = True
                else:
                    threads[started] = _Thread(control)
                    started += 1
            self._answer([leaf for thread in threads.values() for leaf in thread.leaves()])
            for k, thread in list(threads.items()):
                if thread.advance():
                    done[k] = threads.pop(k).result
            while following in done:
                yield done.pop(following)
                following += 1
            if exhausted and not threads:
                return

    def _answer(self, leaves: "list[_Thread]") -> None:
        groups: dict[Any, list[_Thread]] = defaultdict(list)
        for leaf in leaves:
            groups[_group_of(leaf.request)].append(leaf)
        for group, members in groups.items():
            answer = {
                MatchSegment: lambda asked: match(asked, self._candidate_score, self._match_score),
                ScoreMatch: lambda asked: score(asked, self._match_score),
                FitPoses: fit,
                Segmentation: segment,
                LifeEvidence: life_evidences,
            }[group[0]]
            distinct = {id(leaf.request): leaf.request for leaf in members}  # controls may wait for the same request
            answers = dict(zip(distinct, answer(list(distinct.values()))))
            for member in members:
                member.answer = answers[id(member.request)]


class _Thread:
    """A control in flight, with the threads below it if it waits for several."""

    def __init__(self, control: Control):
        self._control = control
        self._below: list[_Thread] = []
        self.request: Any = None
        self.answer: Any = None
        self.result: Any = None
        self._done = False
        self._step(None)

    def _step(self, answer: Any) -> None:
        try:
            self.request = self._control.send(answer)
        except StopIteration as stop:
            self.result, self._done, self.request = stop.value, True, None
            return
        if isinstance(self.request, Together):
            self._below = [_Thread(control) for control in self.request.controls]

    def leaves(self) -> "list[_Thread]":
        """The threads at or below this one that wait for a kernel."""
        if self._done:
            return []
        if isinstance(self.request, Together):
            return [leaf for thread in self._below for leaf in thread.leaves()]
        return [self]

    def advance(self) -> bool:
        """Goes on with the answers that have come; whether the control is done."""
        if self._done:
            return True
        if isinstance(self.request, Together):
            if all([thread.advance() for thread in self._below]):
                self._step([thread.result for thread in self._below])
        else:
            self._step(self.answer)
        return self._done


def _group_of(request: Any) -> tuple:
    if isinstance(request, MatchSegment):
        points = bucket(len(request.points), POINT_BUCKETS, "points")
        return MatchSegment, points, bucket(len(request.target.markers), COLUMN_BUCKETS, "markers of a segment")
    if isinstance(request, FitPoses):
        return FitPoses, bucket(request.shape.shape[1], COLUMN_BUCKETS, "markers of a segment")
    if isinstance(request, ScoreMatch):
        return ScoreMatch, bucket(len(request.scale), COLUMN_BUCKETS, "markers of a segment")
    if isinstance(request, Segmentation):
        return (Segmentation,)
    if isinstance(request, LifeEvidence):
        return LifeEvidence, bucket(request.points.shape[1], SLOT_BUCKETS, "points")
    raise TypeError(f"a control yielded {type(request).__name__}, which is no request")
