"""Sends batches to workers, one each.

What a dead worker leaves behind goes on file by file. What dies once more goes last and alone, as the worker may have
been given something else besides that killed it.
"""

import dataclasses
import itertools
import logging
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from pathlib import Path
from queue import Empty, SimpleQueue

from dshpm_jax._archive.batch import label_batch_telling
from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.outcomes import Outcome, failed
from dshpm_jax._archive.result_status import ResultStatus
from dshpm_jax._archive.run import Executor, Order, Step
from dshpm_jax._archive.workers import Connect, Workers
from dshpm_jax._messages import UsageError
from dshpm_jax._outcomes import FAILED

LOOK_SECONDS = 0.5  # between two looks at what workers tell and how many there are, while no batch ends

_log = logging.getLogger(__name__)


def label_on(connect: Connect) -> Executor:
    """Labels on the workers that `connect` gives, which are asked for only if there is something to do."""

    def execute(steps: Iterator[Step], order: Order) -> Iterator[Outcome]:
        for step in steps:
            if isinstance(step, Outcome):
                yield step
                continue
            with connect() as workers:
                yield from _Dispatcher(workers, order).run(itertools.chain([step], steps))

    return execute


class _Dispatcher:
    def __init__(self, workers: Workers, order: Order):
        self._workers = workers
        self._order = dataclasses.replace(order, out=order.out.absolute())
        self._running: dict[Future, list[Job]] = {}
        self._again: deque[list[Job]] = deque()
        self._suspects: deque[list[Job]] = deque()
        self._killed: dict[Job, int] = {}  # workers, by a file that was in a batch of its own
        self._told: SimpleQueue[Outcome | str] = SimpleQueue()  # by workers that have not ended their batch
        self._sent: dict[Path, Job] = {}  # by target: the job here of one that may have other paths on its worker
        self._given: set[Path] = set()  # targets of the outcomes that went on

    def run(self, steps: Iterator[Step]) -> Iterator[Outcome]:
        while True:
            yield from self._fill(steps)
            if not self._running:
                return
            wait(self._running, timeout=LOOK_SECONDS, return_when=FIRST_COMPLETED)
            yield from self._new()
            yield from self._finished()

    def _fill(self, steps: Iterator[Step]) -> Iterator[Outcome]:
        """Sends batches until each worker has one; more would only be lost with a worker that dies."""
        room = max(1, self._workers.how_many())
        while len(self._running) < room:
            step = self._following(steps)
            if step is None:
                return
            if isinstance(step, Outcome):
                yield step
            else:
                self._send(step)

    def _following(self, steps: Iterator[Step]) -> Step | None:
        """What is to be done next; `None` while there is nothing, or what is left has to run alone."""
        if self._again:
            return self._again.popleft()
        step = next(steps, None)
        if step is None and self._suspects and not self._running:
            return self._suspects.popleft()
        return step

    def _send(self, batch: list[Job]) -> None:
        jobs = [_absolute(job) for job in batch]
        self._sent |= {job.target: job for job in batch}
        about = jobs, self._order.out, self._order.settings
        self._running[self._workers.submit(self._told.put, label_batch_telling, *about)] = batch

    def _new(self) -> Iterator[Outcome]:
        """What workers have told since."""
        while True:
            try:
                told = self._told.get_nowait()
            except Empty:
                return
            if isinstance(told, str):
                self._order.notice(told)
            else:
                yield from self._once([told])

    def _once(self, outcomes: Sequence[Outcome]) -> Iterator[Outcome]:
        """Those of which no outcome went on yet: what is told comes again at the end of its batch."""
        for outcome in outcomes:
            target = outcome.job.target
            if target not in self._given:
                self._given.add(target)
                yield dataclasses.replace(outcome, job=self._sent[target])

    def _finished(self) -> Iterator[Outcome]:
        for future in [future for future in self._running if future.done()]:
            batch = self._running.pop(future)
            try:
                outcomes = future.result()
            except UsageError:  # there are no workers
                raise
            except Exception as error:
                if deaths := self._workers.deaths(error):
                    yield from self._on_worker_death(batch, deaths)
                else:  # what no file is to blame for: the connection, or an environment without us
                    yield from self._once([failed(job, error) for job in batch])
            else:
                yield from self._once(outcomes)

    def _on_worker_death(self, batch: Sequence[Job], workers: int) -> Iterator[Outcome]:
        """Goes on after the death of the worker, or of several in turn, that labelled `batch`."""
        _log.debug("%d workers died over %s", workers, ", ".join(str(job.source) for job in batch))
        status = ResultStatus(self._order.out, self._order.settings, self._order.force)
        left = [job for job in batch if job.target not in self._given]
        for job in left:
            found = status.of(job)
            if isinstance(found, Outcome):  # it was done before the worker died
                yield from self._once([found])
            elif len(batch) > 1:
                self._again.append([job])
            elif job in self._killed:  # so it was alone
                self._killed[job] += workers
                yield from self._once([Outcome(job, FAILED, self._blame(job))])
            else:
                self._killed[job] = workers
                self._suspects.append([job])

    def _blame(self, job: Job) -> str:
        memory = self._workers.memory
        limit = f"than the {memory / 1e9:.1f} GB that each may use" if memory else "than there is"
        times = self._killed[job]
        return (
            f"{job.source}: killed its worker {times} times (crashed it, or needed more memory {limit}); set aside, "
            "label it alone or with fewer workers"
        )


def _absolute(job: Job) -> Job:
    """For workers that may run in another folder."""
    models, beside = (tuple(path.absolute() for path in paths) for paths in (job.models, job.beside))
    return dataclasses.replace(job, source=job.source.absolute(), models=models, beside=beside)
