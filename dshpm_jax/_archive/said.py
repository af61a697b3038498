"""What persons have said about a result, and what of it a recording and a model can take up."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dshpm_jax._archive.jobs import Job
from dshpm_jax._corrections import Corrections, check_belongs, corrections_path, read_corrections
from dshpm_jax._known import KnownLabel
from dshpm_jax._recording import Recording

APPLIED, KNOWN = "corrections", "known"
"""In sidecars: the ids of the corrections that their labels have, and what these say: a column, its first and its last
frame, a label."""

MOST_NAMES = 6  # in a note


@dataclass(frozen=True)
class Said:
    """What persons have said about a recording.

    Attributes:
        known: labels that are known from it.
        applied: the ids of the corrections that say so.
        notes: what cannot be taken up, a sentence each.
    """

    known: tuple[KnownLabel, ...] = ()
    applied: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def record(self) -> dict[str, Any]:
        """What the sidecar holds of it; nothing where nobody said anything."""
        if not self.applied:
            return {}
        spans = [[one.column, one.first, (one.last or 0) - 1, one.label] for one in self.known]
        return {APPLIED: list(self.applied), KNOWN: spans}


def corrections_of(job: Job, out: Path) -> Corrections | None:
    """The corrections beside the place of a job's result; `CorrectionsError` where they are damaged."""
    return read_corrections(corrections_path(out / job.target))


def applied_of(corrections: Corrections | None) -> list[str]:
    """The ids of the corrections that stand."""
    return [] if corrections is None else [one.id for one in corrections.standing]


def said_about(job: Job, out: Path, recording: Recording, markers: Sequence[str]) -> Said:
    """What the corrections of a job say that its recording and the model's `markers` can take up.

    Points whose label is no marker of the model are no marker.

    Raises:
        CorrectionsError: they are damaged, or those of another recording.
    """
    found = corrections_of(job, out)
    if found is None:
        return Said()
    path = corrections_path(out / job.target)
    check_belongs(found, path, job.source)
    notes = [f"{path}: its last line was cut off by a crash and is left out"] if found.torn else []
    known = found.known()
    strange = sorted({one.label for one in known if one.label is not None and one.label not in markers})
    if strange:
        more = f" and {len(strange) - MOST_NAMES} more" if len(strange) > MOST_NAMES else ""
        names = ", ".join(strange[:MOST_NAMES]) + more
        notes.append(f"{path}: corrections say {names}, which are no markers of the model; these points get no label")
    there = [one for one in known if one.column in recording.columns]
    if len(there) < len(known):
        notes.append(f"{path}: {len(known) - len(there)} corrections are of columns that are left out as no markers")
    fitting = (KnownLabel(k.column, k.first, k.last, k.label if k.label in markers else None) for k in there)
    return Said(tuple(fitting), tuple(applied_of(found)), tuple(notes))
