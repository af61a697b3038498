"""Processes that label: of this machine, or those of a dask scheduler that is running."""

import json
import logging
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, NamedTuple
from uuid import uuid4

from dshpm_jax._console import complain
from dshpm_jax._messages import UsageError
from dshpm_jax._processes import ProcessPool, WorkerDied, machine_memory

MEMORY_SHARE = 0.9  # of the machine's memory, shared out among the workers
CONNECT_SECONDS = 20


class Workers(NamedTuple):
    """Where batches go.

    Attributes:
        submit: runs a call on one of them: `submit(told, function, *arguments)`. The function takes `tell` besides,
            and what it tells goes to `told` at once, in another thread.
        how_many: how many there are now.
        deaths: how many of them died over a call that raised this; none if it was something else.
        memory: what each may use (bytes), if that is known.
    """

    submit: Callable[..., Future]
    how_many: Callable[[], int]
    deaths: Callable[[Exception], int]
    memory: int | None = None


Connect = Callable[[], AbstractContextManager[Workers]]


@contextmanager
def local_workers(count: int, memory: int | None = None) -> Iterator[Workers]:
    """Worker processes on this machine; one that dies is started again.

    Arguments:
        memory: what each may use (bytes); one that needs more is ended. By default a share of the machine's memory.
    """
    if memory is None and (whole := machine_memory()):
        memory = int(MEMORY_SHARE * whole / count)
    pool = ProcessPool(count, memory)
    try:
        yield Workers(pool.submit_telling, lambda: count, lambda error: int(isinstance(error, WorkerDied)), memory)
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def workers_of(address: str | None, file: Path | None) -> Iterator[Workers]:
    """The workers of a scheduler that runs elsewhere, given by its address or by the file that it wrote."""
    distributed = _distributed()
    if file:
        address = _address_in(file)
    try:
        client = distributed.Client(address, timeout=CONNECT_SECONDS)
    except (OSError, ValueError) as error:
        remedy = "check that it runs and can be reached from here"
        raise UsageError(f"{address}: no scheduler answers ({' '.join(str(error).split())}); {remedy}") from None

    def how_many() -> int:
        return len(client.nthreads())

    def deaths(error: Exception) -> int:
        return getattr(error, "allowed_failures", 0) + 1 if isinstance(error, distributed.KilledWorker) else 0

    with client:
        if not how_many():
            complain(f"{address}: the scheduler has no workers yet, waiting for them")
        calls = client.get_executor(pure=False)
        try:
            yield Workers(_Telling(client, calls).submit, how_many, deaths)
        finally:
            calls.shutdown(wait=False)  # which cancels what is left


class _Telling:
    """Calls on dask workers that tell of what they do: as events of one topic, numbered by the call."""

    def __init__(self, client: Any, calls: Any):
        self._calls = calls
        self._topic = f"dshpm-jax-{uuid4().hex}"
        self._told: list[Callable[[Any], object]] = []
        client.subscribe_topic(self._topic, self._on_event)

    def submit(self, told: Callable[[Any], object], function: Callable, *arguments: Any) -> Future:
        self._told.append(told)
        return self._calls.submit(_tell_dask, self._topic, len(self._told) - 1, function, arguments)

    def _on_event(self, event: tuple[float, Any]) -> None:
        call, value = event[1]
        self._told[call](pickle.loads(value))


def _tell_dask(topic: str, call: int, function: Callable, arguments: tuple) -> Any:
    """Runs on a worker of dask."""
    from distributed import get_worker

    worker = get_worker()
    return function(*arguments, tell=lambda value: worker.log_event(topic, (call, pickle.dumps(value))))


def _distributed() -> Any:
    """The module; what it logs goes where our own log goes."""
    try:
        import distributed
    except ModuleNotFoundError as missing:
        remedy = "pip install 'dshpm-jax[cluster]'"
        raise UsageError(f"schedulers need dask.distributed, which is not here ({missing}); {remedy}") from None
    for name in ("distributed", "tornado"):
        logger = logging.getLogger(name)
        logger.handlers = logging.getLogger("dshpm_jax").handlers or [logging.NullHandler()]
        logger.propagate = False
    return distributed


def _address_in(file: Path) -> str:
    try:
        return json.loads(file.read_text())["address"]
    except (OSError, ValueError, KeyError, TypeError):
        remedy = "give the file that 'dask scheduler --scheduler-file' wrote"
        raise UsageError(f"{file}: no address of a scheduler can be read; {remedy}") from None
