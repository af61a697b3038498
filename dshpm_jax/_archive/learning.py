"""What a subject's model can be made of again: results that a person confirmed, and labels that are sure."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from dshpm_jax import io
from dshpm_jax._archive.completeness import percent
from dshpm_jax._archive.hashes import hash_file
from dshpm_jax._archive.manifest import MANIFEST_NAME, known_rows
from dshpm_jax._archive.said import APPLIED, applied_of
from dshpm_jax._corrections import CorrectionsError, corrections_path, read_corrections
from dshpm_jax._messages import UsageError
from dshpm_jax._outcomes import LABELLED
from dshpm_jax._recording import Recording
from dshpm_jax.report._doubts import SURE


@dataclass(frozen=True)
class Lesson:
    """A result of a run, and what of it a model may be made of.

    Attributes:
        result: its file.
        recording: the labels that count; None where none does.
        why: what is used of it, or why nothing is.
    """

    result: Path
    recording: Recording | None
    why: str

    def __str__(self) -> str:
        return f"{self.result}: {'used' if self.recording else 'not used'}, {self.why}"


def lessons(folder: Path, confirmed: bool = False) -> list[Lesson]:
    """What the results in a folder give: all labels of results that a person confirmed, and sure labels of the others.

    Arguments:
        confirmed: whether only those count that a person confirmed.

    Raises:
        UsageError: the folder holds no results, or those of several subjects.
    """
    if not (folder / MANIFEST_NAME).is_file():
        raise UsageError(f"{folder}: holds no {MANIFEST_NAME}; give a folder that 'label' wrote")
    rows = [row for row in known_rows(folder).values() if row["output"] and (folder / row["output"]).is_file()]
    rows.sort(key=lambda row: row["output"])
    subjects = sorted({tuple(row["models"]) for row in rows})
    if len(subjects) > 1:
        names = " and ".join(" with ".join(models) for models in subjects[:2])
        raise UsageError(f"{folder}: holds results of several subjects ({names}); give the folder of one")
    return [_lesson(folder / row["output"], row, confirmed) for row in rows]


def _lesson(result: Path, row: Mapping[str, Any], confirmed: bool) -> Lesson:
    try:
        corrections = read_corrections(corrections_path(result))
        sidecar = io.read_sidecar(io.sidecar_path(result))
        if sidecar is None:
            return Lesson(result, None, "as its sidecar is not there; label it again")
        if hash_file(result) != sidecar.get("output"):
            return Lesson(result, None, "as another program changed it after it was labelled")
        if sidecar.get(APPLIED, []) != applied_of(corrections):
            return Lesson(result, None, "as it was corrected since it was made; label it again")
        if corrections is not None and corrections.confirmed:
            return Lesson(result, _labelled(result, sidecar, sure=False), "confirmed")
        if confirmed:
            return Lesson(result, None, "as nobody has confirmed it")
        if row["outcome"] != LABELLED:
            return Lesson(result, None, f"as it is {row['outcome']}")
        recording = _labelled(result, sidecar, sure=True)
    except (io.ReadError, CorrectionsError) as error:
        return Lesson(result, None, f"as {error}")
    if not recording.present.any():
        return Lesson(result, None, "as none of its labels is sure")
    share = recording.present.sum() / max(row.get("labelled_points", 0), 1)
    return Lesson(result, recording, f"the {percent(min(share, 1.0))} of its labels that are sure")


def _labelled(result: Path, sidecar: Mapping[str, Any], sure: bool) -> Recording:
    """The markers of a result; with `sure`, without labels that are not."""
    how, markers = sidecar.get("settings", {}), sidecar["markers"]
    drop = [*io.kept(markers), *how.get("drop", ())]
    found = io.read(result, how.get("unlabelled", ()), drop, how.get("frozen_gaps", True))
    place = {name: found.labels.index(name) for name in markers if name in found.labels}
    points = found.points[:, list(place.values())].copy()
    number = {name: k for k, name in enumerate(place)}
    for label, first, last in _unsure(sidecar) if sure else ():
        if label in number:
            points[first : last + 1, number[label]] = np.nan
    columns = tuple(found.columns[c] for c in place.values())
    return replace(found, points=points, labels=tuple(place), columns=columns)


def _unsure(sidecar: Mapping[str, Any]) -> Iterator[tuple[str, int, int]]:
    """Labels that are not sure, and in which frames; both ends belong to them."""
    for row in sidecar["trajectories"]:
        if row["label"] is not None and row["confidence"] < SURE:
            yield row["label"], *row["frames"]
