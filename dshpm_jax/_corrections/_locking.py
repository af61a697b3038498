"""A lock on a file, which the system takes back from a process that ends, however it ends."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

PAUSE_SECONDS = 0.02  # between two tries


class Locked(Exception):
    """Somebody else holds the lock."""


if sys.platform == "win32":
    import msvcrt

    FAR = 1 << 30  # a byte beyond any content: a lock there keeps nobody from reading

    def _take(file: BinaryIO) -> None:
        file.seek(FAR)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)

    def _leave(file: BinaryIO) -> None:
        file.seek(FAR)
        msvcrt.locking(file.fileno(), msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    def _take(file: BinaryIO) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _leave(file: BinaryIO) -> None:
        fcntl.flock(file, fcntl.LOCK_UN)


@contextmanager
def locked(path: Path, patience: float = 0.0) -> Iterator[BinaryIO]:
    """Holds the lock on a file, which is made where there is none; gives it opened for reading and writing.

    Whoever does not ask for the lock can read and write all the same.

    Arguments:
        patience: for how many seconds to wait for somebody who holds it.

    Raises:
        Locked: somebody else holds it for longer.
        OSError: the file cannot be opened.
    """
    path.touch()
    with path.open("r+b") as file:
        until = time.monotonic() + patience
        while True:
            try:
                _take(file)
                break
            except OSError:
                if time.monotonic() >= until:
                    raise Locked(f"{path}: another program holds its lock; end it, or try again") from None
                time.sleep(PAUSE_SECONDS)
        try:
            yield file
        finally:
            file.flush()
            _leave(file)
