"""Marker sets as JSON that people can read, compare and correct; files like those of subjects, with a kind."""

from pathlib import Path

import numpy as np

from dshpm_jax._marker_set import MarkerSet
from dshpm_jax._model import SubjectModel
from dshpm_jax.io._atomic import write_whole
from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._fields import decode, encode
from dshpm_jax.io._model_file import FORMAT, SET_KIND, check_model, layout, read_entries, read_model

VERSION = 3
"""Of what is written. The numbers are shared with models of subjects, so that a program that knows no marker sets says
that it does not know the version."""

MOST_LOG = 12.0
"""log mm; no body is 160 m large."""

_REMEDY = "make it again with 'dshpm-jax model --subjects' or correct that entry"


def write_marker_set(markers: MarkerSet, path: str | Path) -> None:
    """Writes a marker set (`markers`) as JSON, whole or not at all.

    What is at `path` is replaced, whatever it is; the folder must be there.
    """
    head = {"format": FORMAT, "kind": SET_KIND, "version": VERSION}
    write_whole(Path(path), [(layout(head | encode(markers)) + "\n").encode(errors="backslashreplace")])


def read_marker_set(path: str | Path) -> MarkerSet:
    """Reads a marker set.

    Raises:
        ReadError: the file cannot be read or is none; it names the entry that is wrong.
    """
    path = Path(path)
    found = read_entries(path)
    if found.pop("kind", None) != SET_KIND:
        raise ReadError(path, "is a subject's model and no marker set", "make one with 'dshpm-jax model --subjects'")
    if (version := found.pop("version", None)) != VERSION:
        raise ReadError(path, f"has version {version}, this program knows {VERSION}", "make it again")
    try:
        markers = decode(MarkerSet, found, "the marker set", {})
        _check(markers)
    except ValueError as error:
        raise ReadError(path, str(error), _REMEDY) from None
    return markers


def read_model_or_set(path: str | Path) -> SubjectModel | MarkerSet:
    """Reads what recordings can be labelled with: a subject's model, a subject file or a marker set."""
    return read_marker_set(path) if is_marker_set(path) else read_model(path)


def is_marker_set(path: str | Path) -> bool:
    """Whether a file says that it is a marker set, sound or not."""
    path = Path(path)
    if path.suffix.lower() != ".json":
        return False
    try:
        return read_entries(path).get("kind") == SET_KIND
    except (ReadError, OSError):
        return False


def _check(markers: MarkerSet) -> None:
    """Raises ValueError where the parts of a set contradict each other."""
    check_model(markers.model)
    if markers.model.markers != markers.markers:
        raise ValueError("the marker set.model has other markers")
    if len(markers.sizes) != len(markers.subjects) or not markers.subjects:
        raise ValueError(f"the marker set has {len(markers.sizes)} sizes for {len(markers.subjects)} subjects")
    for name in ("mean_log", "between_sd", "within", "spread_log", "spread_sd", "components"):
        table = getattr(markers, name)
        if not np.array_equal(table, table.swapaxes(-1, -2), equal_nan=True):
            raise ValueError(f"the marker set.{name} is not symmetric")
        if (np.abs(table) > MOST_LOG).any():
            raise ValueError(f"the marker set.{name} holds numbers beyond {MOST_LOG:g}")
    off = ~np.eye(markers.num_markers, dtype=bool)
    for name in ("between_sd", "spread_sd"):
        if (getattr(markers, name)[off] <= 0).any():
            raise ValueError(f"the marker set.{name} holds numbers that are not above 0")
    for k, four in enumerate(markers.fours):
        known = set(four.markers) <= set(range(markers.num_markers))
        if not known or len(set(four.markers)) != 4:
            raise ValueError(f"the marker set.fours[{k}] does not name four markers")
        if not (np.isfinite(four.mean) and four.sd > 0):
            raise ValueError(f"the marker set.fours[{k}] holds missing or negative numbers")
