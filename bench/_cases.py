"""Recordings with their models and truths, as `evaluate.py` leaves them: WORK/archive/GROUP/..., WORK/*.npz."""

import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _truth import name_of

from dshpm_jax import Recording, SubjectModel, read, read_model

WITHOUT = "-without-"  # in the name of a group whose model is of all subjects but one
BEFORE_SIZE = re.compile(r"(.*)-\d+(?:-.*)?")  # the name of a group up to its number of markers


@dataclass(frozen=True)
class Case:
    """A recording to be labelled.

    Attributes:
        name: group and file, without suffix.
        data_set: cases of one data set are left out together.
        file, model, truth: where they are.
    """

    name: str
    data_set: str
    file: Path
    model: Path
    truth: Path

    def read(self) -> tuple[Recording, SubjectModel, dict[str, np.ndarray]]:
        return read(self.file), read_model(self.model), dict(np.load(self.truth))


def cases(work: Path, only: str = "", lists: Iterable[Path] = ()) -> list[Case]:
    """All cases below WORK/archive whose path there matches `only` and of which there is a truth, sorted by name.

    Arguments:
        lists: case lists (TOML) that say in which folder the data of each group are; see `data_set`.
    """
    archive, folders = work / "archive", folders_of(lists)
    found = []
    for file in sorted(archive.rglob("*.c3d")):
        inner, truth = file.relative_to(archive), work / name_of(file, archive)
        if re.search(only, str(inner)) and truth.exists():
            name = str(inner.with_suffix(""))
            found.append(Case(name, data_set(inner.parts[0], folders), file, file.parent / "model.json", truth))
    if not found:
        raise SystemExit(f"{archive}: no recording with a truth in {work}")
    return found


def folders_of(lists: Iterable[Path]) -> dict[str, str]:
    """The folder of each group's data, as the case lists have it."""
    groups = [group for path in lists for group in tomllib.loads(path.read_text())["group"]]
    return {group["name"]: group["folder"] for group in groups}


def data_set(group: str, folders: dict[str, str]) -> str:
    """What a group is left out with: the folder of its data; if that is not known, its name up to the last number,
    that of its markers, so that "walk-39-static-only" goes with "walk-39"."""
    name = group.partition(WITHOUT)[0]
    before = BEFORE_SIZE.fullmatch(name)
    return folders.get(name) or (before[1] if before else name)
