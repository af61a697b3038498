"""`check`: audits the labels that a recording has against the model of its subject."""

from dataclasses import dataclass, replace

import numpy as np

from dshpm_jax._control.uses.audit import Doubt, audit
from dshpm_jax._driver import Driver
from dshpm_jax._given import GivenModel, GivenRecording, model_of, recording_of
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording, check_names_apart
from dshpm_jax._settings import Settings
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True)
class Finding:
    """A column of a recording whose label is wrong, or lacking, in a range of frames.

    Attributes:
        label: its name in the recording; a capture system's placeholder, or nothing, where it has none.
        column: its place in the recording.
        first, last: frames, counted from 0; both belong to the range.
        should_be: the marker that it is, None if it is no marker of the model, or has leapt off its place.
        evidence: how decisive that is (nats): by how much other labels explain the recording better, or by how much
            the evidence for the label falls; a few are much.
    """

    label: str
    column: int
    first: int
    last: int
    should_be: str | None
    evidence: float


def check(
    recording: GivenRecording, model: GivenModel, settings: Settings | None = None, driver: Driver | None = None
) -> list[Finding]:
    """What is wrong with the labels of a recording: exchanged, on another marker's point, on no marker, or lacking;
    and where a labelled point leaps off its place for some frames.

    Only what is decisively better otherwise is reported, so that sound labels are left in peace, and so may be a few
    wrong ones. Labels that the model does not know are taken for none.

    Arguments:
        recording: points in millimetres, its columns labelled; or its file.
        model: of the subject, or its file; best made from other recordings.
        settings, driver: as for `label`; the method is always "full".

    Returns:
        findings in the order of columns and frames.

    Raises:
        ReadError: a file cannot be read.
        ValueError: the model knows none of the labels, or has no neighbourhoods, or two columns have one label.
    """
    model = model_of(model)
    recording = recording_of(recording, model, settings)
    seen = np.flatnonzero(recording.present.any(0))
    if not {recording.labels[column] for column in seen} & set(model.markers):
        raise ValueError("none of its labels is in the model; give a labelled recording and the model of its subject")
    check_names_apart(recording)
    driver = Driver() if driver is None else driver
    settings = replace(Settings() if settings is None else settings, method="full")
    doubts: list[Doubt] = next(driver.run([audit(recording, model, settings)]))
    return [_finding(doubt, recording, model) for doubt in doubts]


def _finding(doubt: Doubt, recording: Recording, model: SubjectModel) -> Finding:
    should_be = None if doubt.should_be == NO_MATCH else model.markers[doubt.should_be]
    return Finding(recording.labels[doubt.column], doubt.column, doubt.first, doubt.last, should_be, doubt.nats)
