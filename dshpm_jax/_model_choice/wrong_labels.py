"""Recordings whose labels the model of the other recordings contradicts."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from dshpm_jax import io
from dshpm_jax._model import SubjectModel
from dshpm_jax._model_building import TUNING
from dshpm_jax._recording import Recording

if TYPE_CHECKING:
    from dshpm_jax._check import Finding

FOLDS = 5
"""count; used in `_suspects`: recordings are judged in this many groups, each by the model of the other groups; by
hand: a model for each of fifty recordings would take an hour."""

FEWEST = 3
"""count; used in `find_wrong_labels`: among fewer recordings nobody tells which one is wrong, unless one also
contradicts the rest of itself; otherwise a recording is left out only where at least two others agree."""

SHORT = TUNING.trimmed_share
"""share; used in `_wrong`: a label that is wrong in no more of the frames harms no model, whose distances are trimmed
by this share."""


@dataclass
class Verdict:
    """What `check` says about the labels of several recordings.

    Attributes:
        kept: places of the recordings that a model may be made of.
        wrong: places of those that it should not be made of, and why.
        undecided: places of recordings that contradict the only other one, and in what.
    """

    kept: list[int]
    wrong: dict[int, str] = field(default_factory=dict)
    undecided: dict[int, str] = field(default_factory=dict)


def find_wrong_labels(recordings: Sequence[Recording]) -> Verdict:
    """Leaves out the recording whose labels are contradicted most, and looks again at those contradicted besides.

    A wrong recording spoils the model by which the others are judged, so one is left out at a time.
    """
    verdict = Verdict(list(range(len(recordings))))
    suspects = _suspects(recordings, verdict.kept, verdict.kept)
    while suspects and len(verdict.kept) >= FEWEST:
        worst = max(suspects, key=lambda k: sum(finding.evidence for finding in suspects[k]))
        verdict.kept.remove(worst)
        verdict.wrong[worst] = _why(recordings[worst], suspects.pop(worst))
        suspects = _suspects(recordings, suspects, verdict.kept)
    if suspects and len(verdict.kept) > 1 and (wrong := _judged_by_what_agrees(recordings, verdict.kept, suspects)):
        k, findings = wrong
        verdict.kept.remove(k)
        verdict.wrong[k] = _why(recordings[k], findings)
        suspects = {}
    verdict.undecided = {k: _why(recordings[k], findings) for k, findings in suspects.items()}
    return verdict


def _judged_by_what_agrees(
    recordings: Sequence[Recording], kept: Sequence[int], suspects: Mapping[int, Sequence["Finding"]]
) -> tuple[int, list["Finding"]] | None:
    """The one of two recordings that is still contradicted by the model of what they do not contradict each other in.

    A label that is wrong for a while contradicts the other recording and the rest of its own; that is a majority.
    """
    agreed = [_without(recordings[k], suspects.get(k, ())) for k in kept]
    audits = zip(kept, _audits([recordings[k] for k in kept], agreed))
    still = {k: findings for k, findings in audits if findings}
    return next(iter(still.items())) if len(still) == 1 else None


def _without(recording: Recording, findings: Sequence["Finding"]) -> Recording:
    """The recording without the points that findings are about."""
    points = np.array(recording.points)
    for finding in findings:
        points[finding.first : finding.last + 1, finding.column] = np.nan
    return replace(recording, points=points)


def _suspects(
    recordings: Sequence[Recording], judged: Collection[int], kept: Sequence[int]
) -> dict[int, list["Finding"]]:
    """The wrong labels of each recording of `judged` that has any, by models of others of `kept`."""
    found = {}
    for fold in (kept[k::FOLDS] for k in range(FOLDS)):
        mine = [k for k in fold if k in judged]
        others = [recordings[k] for k in kept if k not in fold]
        if mine and others:
            audits = zip(mine, _audits([recordings[k] for k in mine], others))
            found |= {k: findings for k, findings in audits if findings}
    return found


def _audits(judged: Sequence[Recording], others: Sequence[Recording]) -> Iterator[list["Finding"]]:
    """The wrong labels of each recording; none where the others cannot judge them, for want of markers, say."""
    from dshpm_jax._check import check  # imports jax

    try:
        model = SubjectModel.from_recordings(others)
    except ValueError:
        return
    for recording in judged:
        try:
            findings = check(recording, model)
        except ValueError:
            findings = []
        yield [finding for finding in findings if _wrong(finding, recording)]


def _wrong(finding: "Finding", recording: Recording) -> bool:
    """Whether a finding is about a label, and for long enough to harm a model."""
    seen = int(recording.present[:, finding.column].sum())
    return bool(recording.labelled[finding.column]) and finding.last - finding.first + 1 > SHORT * seen


def _why(recording: Recording, findings: Sequence["Finding"]) -> str:
    first = max(findings, key=lambda finding: finding.evidence)
    offset = io.first_frame(recording.source) if recording.source else 0
    what = f"should be {first.should_be}" if first.should_be else "fits no marker there"
    more = f" ({len(findings) - 1} more)" if len(findings) > 1 else ""
    return f"{first.label}, frames {first.first + offset}-{first.last + offset}, {what}{more}"
