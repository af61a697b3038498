"""One `read` for every format that we know."""

from collections.abc import Sequence
from pathlib import Path

from dshpm_jax._recording import Recording
from dshpm_jax.io._c3d import raw_c3d
from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._how import How
from dshpm_jax.io._judged import judged
from dshpm_jax.io._raw import Raw
from dshpm_jax.io._text import TABLES, looks_like_recording, raw_text

_READERS = {".c3d": raw_c3d, **dict.fromkeys(TABLES, raw_text)}
_OFTEN_SOMETHING_ELSE = (".csv", ".tsv")

SUFFIXES = tuple(_READERS)
"""Endings (in lower case) of the files that `read` reads."""


def read(
    path: str | Path, unlabelled: Sequence[str] = (), drop: Sequence[str] = (), frozen_gaps: bool = True
) -> Recording:
    """Reads a recording, its format told by its ending (one of `SUFFIXES`).

    Points come in millimetres, whatever the file's unit, and NaN where a point was not seen; labels come without the
    subject's prefix, unless two subjects wear markers of the same names. What is doubtful about the file, and which of
    its columns were left out as computed, is said in `Recording.notes`.

    Arguments:
        unlabelled: names of columns that count as none, besides those that capture systems give (see
            `Recording.labels`), with the wildcards of `fnmatch`, as in "ghost*"; such columns get an empty label.
        drop: names of columns to leave out, with wildcards, or their numbers in the file, as in "#12" (from 1); what
            begins with "!" stays although an earlier pattern or its own look as a computed point tells against it.
        frozen_gaps: whether a point of a moving capture that keeps its coordinates to the last bit over several frames
            counts as missing there.

    Raises:
        ReadError: there is no such file, it is damaged or of no known kind, or no point is seen in it.
    """
    return judged(raw(path), How(tuple(unlabelled), tuple(drop), frozen_gaps))


def raw(path: str | Path) -> Raw:
    """What the file of a recording holds, as it is; raises like `read`, but may hold no point."""
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise ReadError(path, f"unknown kind of file '{path.suffix}'", f"give one of {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise ReadError(path, "is a folder" if path.is_dir() else "there is no such file", "check the path")
    return reader(path)


def may_be_recording(path: Path) -> bool:
    """Whether a search takes `path` for a recording: by its ending, and by its content where that is a common one."""
    suffix = path.suffix.lower()
    return suffix in SUFFIXES and (suffix not in _OFTEN_SOMETHING_ELSE or looks_like_recording(path))
