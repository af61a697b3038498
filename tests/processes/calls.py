"""Calls for processes, which import this file."""

import os
import signal
import time


def double(number: int) -> int:
    return 2 * number


def count(number: int, tell) -> int:
    for k in range(number):
        tell(k)
    return number


def tell_and_die(tell) -> None:
    tell("so far")
    die()


def process() -> int:
    return os.getpid()


def cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 0


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def eat_memory() -> None:
    eaten = []
    while True:
        eaten.append(b"x" * (16 << 20))


def refuse(text: str) -> None:
    raise ValueError(text)


def sleep() -> None:
    time.sleep(600)


def interrupt_all() -> str:
    """What Ctrl-C does to the processes of a terminal."""
    os.kill(os.getpid(), signal.SIGINT)
    return "still here"
