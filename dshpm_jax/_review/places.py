"""The trials of a folder of results, each under an id: nothing else in the folder, and nothing outside it, has one."""

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dshpm_jax import io
from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.manifest import known_rows
from dshpm_jax._corrections import corrections_path

ID_DIGITS = 16


@dataclass(frozen=True)
class Place:
    """Where a trial is.

    Attributes:
        id: what the page calls it.
        name: of its result in the folder, as people read it.
        out: the folder of the results.
        job: which recording it is of, with which models.
        row: of the manifest; empty if the recording was never labelled.
    """

    id: str
    name: str
    out: Path
    job: Job
    row: Mapping[str, Any]

    @property
    def result(self) -> Path:
        return self.out / self.job.target

    @property
    def sidecar(self) -> Path:
        return self.out / self.job.sidecar

    @property
    def corrections(self) -> Path:
        return corrections_path(self.result)

    @property
    def lock(self) -> Path:
        """Held by whoever corrects it."""
        return self.result.with_name(f".{self.result.stem}.review.lock")


def places_in(out: Path) -> dict[str, Place]:
    """The trials that were labelled into `out`, by their ids.

    A row of the manifest that leads out of the folder, by its name or by a link, has none.
    """
    found = {}
    for row in known_rows(out).values():
        output = row.get("output")
        if output and is_inside(out, output):
            models = tuple(Path(path) for path in row.get("models", ()))
            place = _place(out, Job(Path(row["input"]), Path(output), models, page=True), row)
            found[place.id] = place
    return found


def place_of(out: Path, job: Job) -> Place:
    """The place of a recording that may never have been labelled; `ValueError` if its result would lie elsewhere."""
    if not is_inside(out, job.target.as_posix()):
        raise ValueError(f"{job.source}: its result would lie outside {out}")
    return _place(out, job, known_rows(out).get(job.target.as_posix(), {}))


def is_inside(out: Path, name: str) -> bool:
    """Whether a name in the folder stays in it, links followed, and is of a kind that we read."""
    path = out / name
    plain = not os.path.isabs(name) and ".." not in Path(name).parts
    return plain and path.suffix.lower() in io.SUFFIXES and path.resolve().is_relative_to(out.resolve())


def _place(out: Path, job: Job, row: Mapping[str, Any]) -> Place:
    name = job.target.as_posix()
    digest = hashlib.sha256(os.fsencode(name)).hexdigest()[:ID_DIGITS]
    return Place(digest, name.encode(errors="replace").decode(), out, job, row)
