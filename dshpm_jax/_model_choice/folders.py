"""The folders of an archive, and what of a folder may be labelled recordings of its subject."""

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._archive.manifest import MANIFEST_NAME
from dshpm_jax._model_building import gather
from dshpm_jax._reading import AS_USUAL, Reading, read_aloud
from dshpm_jax._recording import Recording

FILLED, MOTION = ".filled.c3d", ".motion.npz"
"""Endings of what `reconstruct` writes."""


@dataclass
class FolderContents:
    """The recordings that a folder holds directly, in the order of their names.

    Attributes:
        labelled: those that have labels.
        unlabelled: files of those that have none.
        left_out: files that are no use, and why.
    """

    labelled: list[Recording] = field(default_factory=list)
    unlabelled: list[Path] = field(default_factory=list)
    left_out: dict[Path, str] = field(default_factory=dict)


def folders_of(top: Path, closed: list[OSError]) -> Iterator[Path]:
    """`top` and the folders in it, in the order of their names, each once; results of a run and what is hidden are not
    searched. Folders that cannot be searched are put into `closed`."""
    searched: set[Path] = set()
    for here, folders, files in os.walk(top, onerror=closed.append, followlinks=True):
        real = Path(here).resolve()
        if real in searched or MANIFEST_NAME in files:
            folders.clear()
            continue
        searched.add(real)
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        yield Path(here)


def recordings_in(folder: Path) -> list[Path]:
    """The files directly in a folder that may be recordings, in the order of their names."""
    files = (path for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))
    return sorted(path for path in files if io.may_be_recording(path))


def find(folder: Path, how: Reading = AS_USUAL) -> FolderContents:
    """Reads the recordings directly in a folder; `how` they are read is as for `io.read`."""
    found = FolderContents()
    for path in recordings_in(folder):
        if _is_result(path):
            found.left_out[path] = "a result of this program, whose labels no person has looked at"
            continue
        try:
            recording = read_aloud(path, how)
            if recording.labelled.any():
                gather([recording])  # refuses labels that a model cannot be made of
                found.labelled.append(recording)
            else:
                found.unlabelled.append(path)
        except ValueError as error:
            found.left_out[path] = str(error).removeprefix(f"{path}: ").removeprefix(f"{path.name}: ")
    return found


def _is_result(path: Path) -> bool:
    if path.name.endswith(FILLED) and path.with_name(path.name.removesuffix(FILLED) + MOTION).is_file():
        return True
    return io.sidecar_path(path).is_file()
