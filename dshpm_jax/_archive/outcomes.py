"""What became of each recording."""

import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dshpm_jax import io
from dshpm_jax._archive.jobs import Job
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._labelling import Labelling
from dshpm_jax._settings import Settings
from dshpm_jax._types import NO_MATCH

LABELLED, PARTLY, KEPT, FAILED, PASSED = "labelled", "partly labelled", "kept", "failed", "passed over"


@dataclass(frozen=True)
class Outcome:
    """What became of a job; small, as it may come from another machine.

    Attributes:
        outcome: LABELLED, PARTLY (fewer markers found than `Settings.completeness` asks for), KEPT (a file is there
            that is not overwritten), FAILED or PASSED (a sound file that holds no points).
        message: one line that names the file, unless all is well; of a labelled file, that its model is doubtful.
        hashes: of the input, the model and the settings, as far as they are known.
        figures: of the result, if there is one.
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
    seconds: float | None = None
    was_there: bool = False
    detail: str = ""
    notes: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether the folder of the results now holds what was asked for."""
        return self.outcome in (LABELLED, PASSED)


def judged(job: Job, settings: Settings, hashes: Mapping[str, str], figures: Mapping[str, Any], was_there=False):
    """The outcome of a job that has a result with `figures`."""
    share, fit = figures["completeness"], figures.get("model_fit")
    models = " and ".join(map(str, job.models))
    outcome, message = LABELLED, ""
    if share < settings.completeness:
        outcome, message = PARTLY, f"{job.source}: only {share:.1%} of its markers found; check that {models} is right"
    elif fit is not None and fit < TUNING.poor_fit_below:
        message = f"{job.source}: its labels hold only {fit:.0%} of the usual evidence; check that {models} is right"
    return Outcome(job, outcome, message, hashes, figures, was_there=was_there)


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


def figures_of(labelling: Labelling) -> dict[str, Any]:
    """Figures for manifest and sidecar; the same for the same labels, whoever shared the batch."""
    recording, tracks = labelling.recording, labelling.trajectories
    labelled = labelling.identity != NO_MATCH
    life = (tracks.stop - tracks.start)[labelled]
    sure = float(np.average(labelling.confidence[labelled], weights=life)) if labelled.any() else None
    points = int((labelling.identities != NO_MATCH).sum())
    return {
        "frames": recording.num_frames,
        "points": int(recording.present.sum()),
        "labelled_points": points,
        "trajectories": len(tracks),
        "labelled_trajectories": int(labelled.sum()),
        "completeness": round(points / max(1, recording.num_frames * labelling.model.num_markers), 4),
        "confidence": None if sure is None else round(sure, 4),
        "model_fit": labelling.stats.get("model_fit"),
    }
