"""Processes of this machine that run what they are given, each held to cores and memory of its own.

One thread here serves one process: it hands over a call, waits for the answer and starts the process again where it
died, so that a call that kills its process costs no other call. The standard library's pool breaks as a whole then.
"""

import pickle
import signal
from collections.abc import Callable
from concurrent.futures import Executor, Future
from multiprocessing import get_context, resource_tracker
from queue import Empty, SimpleQueue
from threading import Event, Lock, Thread
from typing import Any

from dshpm_jax._messages import UsageError
from dshpm_jax._processes.worker import GIVEN, TOLD, SetUp, answer_calls

Told = Callable[[Any], object] | None

MOST_FAILED_STARTS = 5  # of a process in a row, before we give up

_SPAWN = get_context("spawn")  # never forked: jax has threads


class WorkerDied(Exception):
    """The process of a call ended before it answered: it crashed, or used more memory than it may."""


class ProcessPool(Executor):
    """Runs calls in `count` processes, in the order in which they come.

    Each process has its share of the cores, where the system can pin processes, and a GPU of its own where there are
    any. None of them hears Ctrl-C, and none outlives this process.

    Arguments:
        memory: bytes that each process may use, where the system tells how many it uses; `None` for no limit.
        set_up: called in each process before anything else, without arguments; goes there by its name.
    """

    def __init__(self, count: int, memory: int | None = None, set_up: SetUp = None):
        self._calls: SimpleQueue[tuple[Future, bytes, Told] | None] = SimpleQueue()
        self._closed = Event()
        if hasattr(signal, "pthread_sigmask"):
            resource_tracker.ensure_running()  # it lets Ctrl-C through again when it starts, so it has to start before
        self._workers = [_Worker(place, count, memory, set_up, self._calls) for place in range(count)]

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        """A call to be run in one of the processes.

        The future raises what the call raises, `WorkerDied` where its process ended, and `UsageError` where no process
        will start.
        """
        return self._submit(None, fn, args, kwargs)

    def submit_telling(self, told: Callable[[Any], object], fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        """The same for a call that takes a function `tell` besides: `told` gets at once what it is called with.

        `told` is called in another thread than this.
        """
        return self._submit(told, fn, args, kwargs)

    def _submit(self, told: Told, fn: Callable, args: tuple, kwargs: dict[str, Any]) -> Future:
        if self._closed.is_set():
            raise RuntimeError("the pool is shut down")
        future: Future = Future()
        self._calls.put((future, pickle.dumps((fn, args, kwargs, told is not None)), told))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ends the processes: after the calls that were submitted, or with `cancel_futures` at once."""
        self._closed.set()
        if cancel_futures:
            self._cancel_waiting()
        for worker in self._workers:
            self._calls.put(None)
            if cancel_futures:
                worker.kill()
        for worker in self._workers if wait else ():
            worker.thread.join()

    def _cancel_waiting(self) -> None:
        try:
            while (call := self._calls.get_nowait()) is not None:
                call[0].cancel()
        except Empty:
            pass


class _Worker:
    """A process, and the thread that serves it; the process is started with its first call."""

    def __init__(self, place: int, count: int, memory: int | None, set_up: SetUp, calls: SimpleQueue):
        self._about = (place, count, memory, set_up)
        self._calls = calls
        self._process: Any = None
        self._connection: Any = None
        self._lock = Lock()  # nothing is started once `kill` was called
        self._killed = False
        self.thread = Thread(target=self._serve, daemon=True)
        self.thread.start()

    def kill(self) -> None:
        with self._lock:
            self._killed = True
            if self._process is not None:
                self._process.kill()

    def _serve(self) -> None:
        if hasattr(signal, "pthread_sigmask"):  # what this thread starts never hears Ctrl-C
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        while (call := self._calls.get()) is not None:
            future, message, told = call
            if future.set_running_or_notify_cancel():
                self._answer(future, message, told)
        if self._process is not None:
            self._connection.close()  # the process ends when it reads that
            self._process.join()

    def _answer(self, future: Future, message: bytes, told: Told) -> None:
        try:
            self._start()
            self._connection.send_bytes(message)
            how, answer = self._connection.recv()
            while how == TOLD:
                if told is not None:
                    told(answer)
                how, answer = self._connection.recv()
        except (EOFError, OSError):
            self._forget()
            future.set_exception(WorkerDied("the process ended"))
        except Exception as error:  # no process starts, or its answer cannot be read
            future.set_exception(error)
        else:
            future.set_result(answer) if how == GIVEN else future.set_exception(answer)

    def _start(self) -> None:
        """Starts the process unless it runs, and waits until it is ready."""
        if self._process is not None and self._process.is_alive():
            return
        for _ in range(MOST_FAILED_STARTS + 1):
            self._forget()
            try:
                with self._lock:
                    if self._killed:
                        raise WorkerDied("the pool was shut down")
                    self._process, self._connection = _started(self._about)
                self._connection.recv()
                return
            except (EOFError, OSError):
                continue
        raise UsageError("no worker process starts here; go without --workers")

    def _forget(self) -> None:
        if self._process is not None:
            self._connection.close()
            self._process.join()
            self._process = None


def _started(about: tuple) -> tuple[Any, Any]:
    """A process and the connection to it, which ends when the process does."""
    ours, theirs = _SPAWN.Pipe()
    try:
        process = _SPAWN.Process(target=answer_calls, args=(theirs, *about), daemon=True)
        process.start()
    except BaseException:
        ours.close()
        raise
    finally:
        theirs.close()
    return process, ours
