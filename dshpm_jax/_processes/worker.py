"""What a process of the pool does."""

import os
import pickle
from collections.abc import Callable
from multiprocessing import parent_process
from pathlib import Path
from threading import Thread
from typing import Any

from dshpm_jax._processes.memory import end_beyond

SetUp = Callable[[], object] | None

TOLD, GIVEN, RAISED = "told", "given", "raised"  # what a call says before its end, gives, or raises
MEMORY_MARGIN = 0.95  # of its memory; a process that uses more is ended


def answer_calls(connection: Any, place: int, count: int, memory: int | None, set_up: SetUp) -> None:
    """What a process does: answers calls until there are no more."""
    Thread(target=_end_with_parent, daemon=True).start()
    if memory is not None:
        Thread(target=end_beyond, args=(MEMORY_MARGIN * memory,), daemon=True).start()
    _take_cores_and_gpu(place, count)
    if set_up is not None:
        set_up()
    connection.send("ready")
    while True:
        try:
            message = connection.recv_bytes()
        except EOFError:
            return
        connection.send_bytes(_answer_to(message, connection))


def _answer_to(message: bytes, connection: Any) -> bytes:
    """What the call gives or raises; what it tells before goes through `connection` at once."""

    def tell(value: object) -> None:
        connection.send_bytes(pickle.dumps((TOLD, value)))

    try:
        function, arguments, named, tells = pickle.loads(message)
        answer = function(*arguments, **named, tell=tell) if tells else function(*arguments, **named)
        return pickle.dumps((GIVEN, answer))
    except Exception as error:
        try:
            return pickle.dumps((RAISED, error))
        except Exception:  # it holds what cannot be sent
            return pickle.dumps((RAISED, RuntimeError(f"{type(error).__name__}: {error}")))


def _take_cores_and_gpu(place: int, count: int) -> None:
    """Takes this process to its cores and its GPU, before anything of jax runs."""
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[place % len(cores) :: count])  # threads that start later inherit it
    os.environ["XLA_PYTHON_CLIENT_PREALLOCATE"] = "false"  # else the first process takes nearly all of a GPU
    if gpus := _gpus():
        os.environ["CUDA_VISIBLE_DEVICES"] = gpus[place % len(gpus)]


def _gpus() -> list[str]:
    """What CUDA_VISIBLE_DEVICES would name."""
    if (visible := os.environ.get("CUDA_VISIBLE_DEVICES")) is not None:
        return [name for name in visible.split(",") if name]
    numbers = (path.name.removeprefix("nvidia") for path in Path("/dev").glob("nvidia*"))
    return sorted((number for number in numbers if number.isdigit()), key=int)


def _end_with_parent() -> None:
    """A process that was killed cannot stop those that it started: they would wait for work, with all their memory."""
    if (parent := parent_process()) is not None:
        parent.join()
        os._exit(1)
