"""Text files of all programs that we know: which one wrote a file, and what it holds."""

import re
from collections.abc import Callable
from pathlib import Path

from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._motive_csv import is_motive, motive_table
from dshpm_jax.io._qtm_tsv import qtm_table
from dshpm_jax.io._raw import Raw
from dshpm_jax.io._text_table import TextLines, TextTable, raw_of_table, read_lines, whole_rows
from dshpm_jax.io._trc import trc_table
from dshpm_jax.io._vicon_csv import is_vicon, vicon_table

_FOREIGN = re.compile(
    rb"(?i)[\r\n](?:\xef\xbb\xbf|\xff\xfe|\xfe\xff)?[\s\",;]*(trajectories|format version|(MARKER|BODY)_NAMES\b)"
)

_EARLIER = re.compile(r'\s*"?(comment|info)\s*"?\s*[,;]', re.IGNORECASE)
"""How the first line of an export by OptiTrack's earlier programs begins."""

_SEARCHED, _AT_ONCE, _OVERLAP = 256 << 20, 1 << 20, 200
"""Bytes of a table that are looked through for trajectories, so many at a time, and how much of them twice."""


def raw_text(path: Path) -> Raw:
    """The points of a text file."""
    return raw_of_table(text_table(path))


def text_table(path: Path) -> TextTable:
    """A text file as a table; its ending, or where that says too little its content, says what it is."""
    return whole_rows(TABLES[path.suffix.lower()](read_lines(path)))


def looks_like_recording(path: Path) -> bool:
    """Whether a file that may be anything, a `.csv` say, says somewhere that it holds trajectories."""
    try:
        with path.open("rb") as file:
            seen = b"\n"
            for _ in range(_SEARCHED // _AT_ONCE):
                more = file.read(_AT_ONCE)
                seen = seen[-_OVERLAP:] + more.replace(b"\0", b"")  # UTF-16 has an empty byte to each letter
                if _FOREIGN.search(seen):
                    return True
                if len(more) < _AT_ONCE:
                    break
        return False
    except OSError:
        return True  # whoever reads it says why it cannot be read


def _csv_table(file: TextLines) -> TextTable:
    if is_motive(file):
        return motive_table(file)
    if is_vicon(file):
        return vicon_table(file)
    if _EARLIER.match(file.lines[0]):
        wrong = "this is a CSV file of a system before Motive (Tracking Tools, Arena), whose layout is not known"
        raise ReadError(file.path, wrong, "open it in Motive, or export C3D or TRC")
    wrong = "this is a CSV file neither of Vicon (no 'Trajectories') nor of Motive (no 'Format Version')"
    raise ReadError(file.path, wrong, "export trajectories, or C3D")


TABLES: dict[str, Callable[[TextLines], TextTable]] = {".trc": trc_table, ".csv": _csv_table, ".tsv": qtm_table}
"""What makes a table of a file with each ending."""
