"""The driver: gathers what many controls ask for, answers it in few kernel calls.

A control is a generator that yields requests (`_requests`). The driver runs many of them, takes the requests that are
waiting, groups those of one kind and bucket, pads them to a few shapes, calls a jitted kernel once a group and sends
each its answer. An answer never depends on who shared the batch.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

from dshpm_jax._driver.evidence import life_evidences
from dshpm_jax._driver.fitting import fit
from dshpm_jax._driver.matching import match, score
from dshpm_jax._driver.quadratic import climbed, softened
from dshpm_jax._driver.segmentation import segment
from dshpm_jax._driver.volumes import volumes
from dshpm_jax._requests import (
    ClimbLabels,
    Control,
    CountFits,
    FitPoses,
    Gather,
    LifeEvidence,
    MatchSegment,
    Request,
    ScoreMatch,
    Segmentation,
    SignedVolumes,
    SoftenLabels,
)
from dshpm_jax._scoring import (
    AbstractCandidateScore,
    AbstractMatchScore,
    MeanResidual,
    ToleranceScore,
    check_candidate_score,
    check_match_score,
)

T = TypeVar("T")


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
        candidate = ToleranceScore() if candidate_score is None else candidate_score
        matching = MeanResidual() if match_score is None else match_score
        self._answers: dict[type[Request[Any]], Callable[[list[Any]], list[Any]]] = {
            MatchSegment: lambda asked: match(asked, candidate, matching),
            ScoreMatch: lambda asked: score(asked, matching),
            FitPoses: fit,
            Segmentation: segment,
            LifeEvidence: life_evidences,
            ClimbLabels: climbed,
            SoftenLabels: softened,
            SignedVolumes: volumes,
        }
        self._in_flight = in_flight

    def run(self, controls: Iterable[Control[T]]) -> Iterator[T]:
        """The results of `controls`, in their order, each as soon as it and those before it are done."""
        waiting = iter(controls)
        done: dict[int, Any] = {}
        tasks: dict[int, _Task] = {}
        started = following = 0
        exhausted = False
        while True:
            while not exhausted and len(tasks) < self._in_flight:
                control = next(waiting, None)
                if control is None:
                    exhausted = True
                else:
                    tasks[started] = _Task(control, _FitCount())
                    started += 1
            self._answer([leaf for task in tasks.values() for leaf in task.leaves()])
            for k, task in list(tasks.items()):
                if task.advance():
                    done[k] = tasks.pop(k).result
            while following in done:
                yield done.pop(following)
                following += 1
            if exhausted and not tasks:
                return

    def _answer(self, leaves: "list[_Task]") -> None:
        groups: dict[tuple, list[_Task]] = defaultdict(list)
        for leaf in leaves:
            groups[type(leaf.request), *leaf.request.group()].append(leaf)
        for (kind, *_), members in groups.items():
            distinct = {id(leaf.request): leaf.request for leaf in members}  # controls may wait for the same request
            answers = dict(zip(distinct, self._answers[kind](list(distinct.values()))))
            for member in members:
                member.answer = answers[id(member.request)]


@dataclass
class _FitCount:
    """Rigid fits that a control took, with all that it runs."""

    fits: int = 0


class _Task:
    """A control in flight, with the tasks below it if it waits for several."""

    def __init__(self, control: Control[Any], count: _FitCount):
        self._control = control
        self._count = count
        self._below: list[_Task] = []
        self.request: Any = None
        self.answer: Any = None
        self.result: Any = None
        self._done = False
        self._step(None)

    def _step(self, answer: Any) -> None:
        try:
            self.request = self._control.send(answer)
            while isinstance(self.request, CountFits):
                self.request = self._control.send(self._count.fits)
        except StopIteration as stop:
            self.result, self._done, self.request = stop.value, True, None
            return
        if isinstance(self.request, Gather):
            self._below = [_Task(control, self._count) for control in self.request.controls]
        elif not isinstance(self.request, Request):
            raise TypeError(f"a control yielded {type(self.request).__name__}, which is no request")

    def leaves(self) -> "list[_Task]":
        """The tasks at or below this one that wait for a kernel."""
        if self._done:
            return []
        if isinstance(self.request, Gather):
            return [leaf for task in self._below for leaf in task.leaves()]
        return [self]

    def advance(self) -> bool:
        """Goes on with the answers that have come; whether the control is done."""
        if self._done:
            return True
        if isinstance(self.request, Gather):
            if all([task.advance() for task in self._below]):
                self._step([task.result for task in self._below])
        else:
            self._count.fits += self.request.fits(self.answer)
            self._step(self.answer)
        return self._done
