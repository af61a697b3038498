"""The file of corrections beside a result: read whole, and appended to a line at a time."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from dshpm_jax import io
from dshpm_jax._corrections._format import (
    Correction,
    correction_line,
    correction_of,
    head_line,
    head_of,
    resolved,
)
from dshpm_jax._corrections._locking import locked
from dshpm_jax._known import KnownLabel, latest

APPEND_PATIENCE = 10.0
"""Seconds; used in `append`: another program that holds the file for longer has stopped."""

SUFFIX = ".corrections.jsonl"


class CorrectionsError(ValueError):
    """A file of corrections that is damaged, or that of another recording; one line says which, and what to do."""


@dataclass(frozen=True)
class Corrections:
    """What persons have said about the labels of a recording.

    Attributes:
        recording: the name of the recording's file.
        points: the hash of its points, see `io.points_hash`.
        lines: all that was done, in order.
        torn: whether the last line was cut off, by a crash, and is left out.
    """

    recording: str
    points: str
    lines: tuple[Correction, ...] = ()
    torn: bool = False

    @property
    def standing(self) -> tuple[Correction, ...]:
        """Corrections and confirmations that are not undone, in order."""
        return tuple(resolved(self.lines)[0])

    @property
    def undoable(self) -> Correction | None:
        """What "undo" would undo: the last that stands."""
        return next(reversed(self.standing), None)

    @property
    def redoable(self) -> Correction | None:
        """What "redo" would bring back: the last undone, unless something was done since."""
        return next(reversed(resolved(self.lines)[1]), None)

    @property
    def confirmed(self) -> bool:
        """Whether a person has confirmed the whole result."""
        return any(one.whole for one in self.standing)

    def known(self) -> tuple[KnownLabel, ...]:
        """The labels that persons have given or confirmed, by column and frame.

        Of one point, and of one label in one frame, the later correction counts.
        """
        said = (one for one in self.standing if one.kind in ("label", "confirm"))
        return latest(change.known for one in said for change in one.changes)


def corrections_path(result: str | Path) -> Path:
    """Where the corrections of a result are: beside it, as `walk.corrections.jsonl`."""
    return Path(result).with_name(f"{Path(result).stem}{SUFFIX}")


def read_corrections(path: str | Path) -> Corrections | None:
    """The corrections that a file holds; None where there is no file, or not one whole line in it.

    A last line that was cut off by a crash is left out, as it never counted.

    Raises:
        CorrectionsError: the file is damaged, or something else.
    """
    try:
        content = Path(path).read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise CorrectionsError(f"{path}: cannot be read ({error.strerror}); check the permissions") from None
    return _parsed(Path(path), content)


def check_belongs(corrections: Corrections, path: str | Path, recording: str | Path) -> None:
    """Raises `CorrectionsError` where the corrections of `path` are not those of the file of `recording`."""
    if corrections.points != io.points_hash(recording):
        raise CorrectionsError(
            f"{path}: holds corrections of {corrections.recording}, and {recording} has other points; "
            "move them away, or put the recording back"
        )


def append(path: str | Path, correction: Correction, recording: str | Path) -> None:
    """Adds a correction to the file, which is made where there is none; when it returns, the line is on the disk.

    Arguments:
        recording: the file of the recording that was labelled; only a new file of corrections needs to look at it.

    Raises:
        CorrectionsError: the file is damaged, or something else.
        Locked: another program has been writing into it for long.
        OSError: it cannot be written.
    """
    path = Path(path)
    is_new = not path.exists()
    with locked(path, APPEND_PATIENCE) as file:
        content = file.read()
        whole = len(_whole_lines(content))
        if _parsed(path, content) is None:
            whole = 0
            _write(file, 0, head_line(Path(recording).name, io.points_hash(recording)))
            whole = file.tell()
        _write(file, whole, correction_line(correction))
    if is_new:
        _keep_name(path.parent)


def _parsed(path: Path, content: bytes) -> Corrections | None:
    lines = _whole_lines(content).splitlines()
    if not lines:
        return None
    number = 1
    try:
        recording, points = head_of(lines[0])
        found = []
        for number, line in enumerate(lines[1:], start=2):
            found.append(correction_of(line))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        what = f"line {number} cannot be understood ({type(error).__name__}: {error})"
        raise CorrectionsError(f"{path}: {what}; mend that line or move the file away") from None
    return Corrections(recording, points, tuple(found), torn=len(_whole_lines(content)) < len(content))


def _whole_lines(content: bytes) -> bytes:
    """Without what follows the last end of a line."""
    return content[: content.rfind(b"\n") + 1]


def _write(file: BinaryIO, place: int, line: bytes) -> None:
    """Writes a line at `place`, in place of what a crash left there."""
    file.seek(place)
    file.truncate()
    file.write(line)
    file.flush()
    os.fsync(file.fileno())


def _keep_name(folder: Path) -> None:
    """Makes the name of a new file last, where the system lets folders be flushed."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(handle)
    except OSError:
        pass
    finally:
        os.close(handle)
