"""Processes that label: spawned here and held to their cores and memory, or those of a scheduler that is running."""

import json
import logging
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from multiprocessing import resource_tracker
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from dshpm_jax._console import complain
from dshpm_jax._messages import UsageError

if TYPE_CHECKING:
    from distributed import Client

MEMORY_SHARE = 0.9  # of the machine's memory, shared out among the workers
CONNECT_SECONDS = 20
MOST_STILLBORN = 5  # processes for each worker wanted that die while they start, before we give up
_CONFIG = {
    # A batch whose worker dies comes back to us at once, and goes on file by file.
    "distributed.scheduler.allowed-failures": 0,
    # Memory in use is the kernels' own: it cannot be spilled, and a worker that waits for it to shrink waits forever.
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": 0.95,
    "distributed.worker.multiprocessing-method": "spawn",
    # By default memory goes back to the system after every array, which takes half as long as all of labelling.
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,
    "distributed.worker.profile.enabled": False,  # a look at what each worker does, a hundred times a second
    "distributed.deploy.lost-worker-timeout": "60s",
    "distributed.comm.timeouts.connect": f"{CONNECT_SECONDS}s",
}


class Workers(NamedTuple):
    """Where batches go.

    Attributes:
        client: of their scheduler.
        revive: starts workers again that did not come back after they died.
        memory: what each may use (bytes), if that is known.
    """

    client: "Client"
    revive: Callable[[], None]
    memory: int | None = None

    def how_many(self) -> int:
        """How many there are now."""
        found: Any = self.client.nthreads()  # a coroutine in asynchronous clients only
        return len(found)


Connect = Callable[[], AbstractContextManager[Workers]]


@contextmanager
def local_workers(count: int, memory: int | None = None) -> Iterator[Workers]:
    """Starts worker processes on this machine; one that dies is started again.

    Each has its own share of the cores where the system can pin processes, and its own GPU where there are any.

    Arguments:
        memory: what each may use (bytes); one that needs more is killed. By default a share of the machine's memory.
    """
    dask, distributed = _dask()
    with dask.config.set(_CONFIG):
        memory = memory or int(MEMORY_SHARE * distributed.system.MEMORY_LIMIT / count)
        options = {"nthreads": 1, "memory_limit": memory, "silence_logs": logging.CRITICAL, "dashboard": False}
        specification = {
            k: {"cls": distributed.Nanny, "options": {**options, "env": _environment(k)}} for k in range(count)
        }
        here = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0", "dashboard": False}  # any port that is free
        scheduler = {"cls": distributed.Scheduler, "options": here}
        with _interrupts_held():
            cluster = distributed.SpecCluster(scheduler=scheduler, silence_logs=False)
        with cluster, distributed.Client(cluster) as client:
            client.register_plugin(_worker_setup(distributed, count))
            cluster.worker_spec.update(specification)
            nursery = Nursery(cluster, count)
            nursery.revive()
            yield Workers(client, nursery.revive, memory)


@contextmanager
def workers_of(address: str | None, file: Path | None) -> Iterator[Workers]:
    """The workers of a scheduler that runs elsewhere, given by its address or by the file that it wrote."""
    _, distributed = _dask()
    if file:
        address = _address_in(file)
    try:
        client = distributed.Client(address, timeout=CONNECT_SECONDS)
    except (OSError, ValueError) as error:
        remedy = "check that it runs and can be reached from here"
        raise UsageError(f"{address}: no scheduler answers ({' '.join(str(error).split())}); {remedy}") from None
    with client:
        workers = Workers(client, lambda: None)
        if not workers.how_many():
            complain(f"{address}: the scheduler has no workers yet, waiting for them")
        yield workers


class Nursery:
    """Starts the processes of a cluster, and those again that died while they started (others come back alone)."""

    def __init__(self, cluster: Any, count: int):
        self._cluster, self._count = cluster, count
        self._stillborn = 0  # since there was a worker

    def revive(self) -> None:
        """Raises `UsageError` where no process will start."""
        if self._cluster.scheduler_info["workers"]:
            self._stillborn = 0
        if self._stillborn > MOST_STILLBORN * self._count:
            raise UsageError("no worker process starts here (see --log-file); label without --workers")
        self._cluster.loop.add_callback(self._start_again)

    def _start_again(self) -> None:
        for name, nanny in list(self._cluster.workers.items()):
            if nanny.status.name in ("closed", "failed"):
                self._stillborn += 1
                del self._cluster.workers[name]
        self._cluster.scale(self._count)


def _dask() -> tuple[Any, Any]:
    """Both modules; what they log goes where our own log goes."""
    try:
        import dask
        import distributed
        import distributed.system
    except ModuleNotFoundError as missing:
        remedy = "pip install 'dshpm-jax[cluster]'"
        raise UsageError(f"workers need dask.distributed, which is not here ({missing}); {remedy}") from None
    for name in ("distributed", "tornado"):
        logger = logging.getLogger(name)
        logger.handlers = logging.getLogger("dshpm_jax").handlers or [logging.NullHandler()]
        logger.propagate = False
    return dask, distributed


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Ctrl-C waits until the end; threads and processes started meanwhile, and all that those start, never hear it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # lets Ctrl-C through again when it starts, so it has to start before
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _environment(worker: int) -> dict[str, str]:
    gpus = _gpus()
    memory = {"XLA_PYTHON_CLIENT_PREALLOCATE": "false"}  # else the first worker takes nearly all of a GPU
    return memory | ({"CUDA_VISIBLE_DEVICES": gpus[worker % len(gpus)]} if gpus else {})


def _gpus() -> list[str]:
    """What CUDA_VISIBLE_DEVICES would name."""
    if (visible := os.environ.get("CUDA_VISIBLE_DEVICES")) is not None:
        return [name for name in visible.split(",") if name]
    numbers = (path.name.removeprefix("nvidia") for path in Path("/dev").glob("nvidia*"))
    return sorted((number for number in numbers if number.isdigit()), key=int)


def _worker_setup(distributed: Any, count: int) -> Any:
    """Pins workers to their cores."""
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []

    class Setup(distributed.WorkerPlugin):
        def setup(self, worker: Any) -> None:
            if cores:
                mine = cores[worker.name % len(cores) :: count]
                os.sched_setaffinity(0, mine)  # of this thread; those that it starts, which label, inherit it

    return Setup()


def _address_in(file: Path) -> str:
    try:
        return json.loads(file.read_text())["address"]
    except (OSError, ValueError, KeyError, TypeError):
        remedy = "give the file that 'dask scheduler --scheduler-file' wrote"
        raise UsageError(f"{file}: no address of a scheduler can be read; {remedy}") from None
