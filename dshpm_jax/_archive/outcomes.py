"""What became of each recording."""

import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dshpm_jax import io
from dshpm_jax._archive.completeness import Lives, completeness, never_seen, percent
from dshpm_jax._archive.doubts import all_doubts, doubts_of
from dshpm_jax._archive.jobs import Job
from dshpm_jax._labelling import Labelling
from dshpm_jax._outcomes import DOUBTFUL, FAILED, LABELLED, PARTLY, PASSED
from dshpm_jax._settings import Settings
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True)
class Outcome:
    """What became of a job; small, as it may come from another machine.

    Attributes:
        outcome: LABELLED, PARTLY (fewer points have a label than `Settings.completeness` asks for), DOUBTFUL (labels
            that may be wrong as a whole), KEPT (a file is there that is not overwritten), FAILED, or PASSED (a sound
            file without points).
        message: one line that names the file, unless all is well.
        hashes: of the input, the model and the settings, as far as they are known.
        figures: of the result, if there is one.
        doubts: why the labels are doubtful, a short sentence each.
        seconds: the file's share of the time that its batch took.
        was_there: whether the result was there before and nothing had to be done.
        detail: the traceback of what failed, for the log.
        notes: what was doubtful about the recording, a sentence each.
    """

    job: Job
    outcome: str
    message: str = ""
    hashes: Mapping[str, str] = field(default_factory=dict)
    figures: Mapping[str, Any] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()
    seconds: float | None = None
    was_there: bool = False
    detail: str = ""
    notes: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether the folder of the results now holds all that the recording can give, and nothing doubtful."""
        return self.outcome in (LABELLED, PASSED)


def judged(job: Job, settings: Settings, hashes: Mapping[str, str], figures: Mapping[str, Any], was_there=False):
    """The outcome of a job that has a result with `figures`; of several troubles the worst."""
    share, doubts = figures["completeness"], all_doubts(figures)
    outcome, wrong = LABELLED, ""
    if doubts:
        outcome, wrong = DOUBTFUL, f"doubtful, {'; '.join(doubts)}"
    elif share < settings.completeness:
        outcome, wrong = PARTLY, f"only {percent(share)} of the points of its markers have a label"
    message = f"{job.source}: {wrong}; check it against {' and '.join(map(str, job.models))}" if wrong else ""
    return Outcome(job, outcome, message, hashes, figures, doubts, was_there=was_there)


def without_points(error: Exception) -> bool:
    """Whether a file could not be read for the sole reason that it is none of points, such as one of EMG alone."""
    return isinstance(error, io.NoPoints)


def failed(job: Job, error: Exception, hashes: Mapping[str, str] | None = None) -> Outcome:
    """The outcome of a job that raised, in one line that names the file."""
    text = " ".join(str(error).split())
    if isinstance(error, OSError) and error.strerror:
        text = f"{error.filename or job.source}: {error.strerror}; check disk and permissions"
    elif not isinstance(error, ValueError):  # nothing that we foresaw
        text = f"{type(error).__name__}: {text}"
    named = isinstance(error, io.ReadError | io.WriteError) or str(job.source) in text
    detail = "".join(traceback.format_exception(error))
    return Outcome(job, FAILED, text if named else f"{job.source}: {text}", hashes or {}, detail=detail)


def passed_over(job: Job, error: Exception) -> Outcome:
    """The outcome of a job `without_points`."""
    return Outcome(job, PASSED, f"{error} (passed over)")


def figures_of(labelling: Labelling) -> dict[str, Any]:
    """Figures for manifest and sidecar; the same for the same labels, whoever shared the batch."""
    recording, tracks = labelling.recording, labelling.trajectories
    labelled = labelling.identity != NO_MATCH
    life = (tracks.stop - tracks.start)[labelled]
    sure = float(np.average(labelling.confidence[labelled], weights=life)) if labelled.any() else None
    judged_by_points = _by_points(Lives.of(labelling))
    return {
        "frames": recording.num_frames,
        "points": int(recording.present.sum()),
        "labelled_points": int(life.sum()),
        "trajectories": len(tracks),
        "labelled_trajectories": int(labelled.sum()),
        **judged_by_points,
        "confidence": None if sure is None else round(sure, 4),
        "model_fit": labelling.stats.get("model_fit"),
        "doubts": doubts_of(labelling, judged_by_points["completeness"]),
    }


def figures_in(sidecar: Mapping[str, Any]) -> dict[str, Any]:
    """The figures that a sidecar holds; those of earlier versions had completeness of all frames."""
    figures = sidecar["figures"] | {"stats": sidecar.get("stats", {})}
    return figures if "never_seen" in figures else figures | _by_points(Lives.of_sidecar(sidecar))


def _by_points(lives: Lives) -> dict[str, Any]:
    return {"completeness": completeness(lives), "never_seen": never_seen(lives)}
