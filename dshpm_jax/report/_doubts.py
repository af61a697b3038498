"""Which labels are in doubt, and why, in plain words."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dshpm_jax._control.tuning import TUNING
from dshpm_jax._labelling import WITHHELD, Reason

SURE = 0.95
"""Labels less sure than this are in doubt, and so are those withheld."""


BADLY, ANOTHERS = "the model fits this trial badly", "the model is another subject's"
BRIEFLY, LOOSELY = "seen too briefly to be sure", "fits its place less well than right labels do"
TIED = "two labels fit almost equally well"

CAUSES = (BADLY, ANOTHERS, BRIEFLY, LOOSELY, TIED)


@dataclass(frozen=True)
class LabelDoubt:
    """A trajectory whose label is in doubt.

    Attributes:
        label: what it was given; None if a label was withheld.
        could_be: what it may be besides; a label withheld comes first.
        frames: its first and last frame, from 0.
        chance: the probability that its label, or the one withheld, is right.
        cause: one of `CAUSES`.
    """

    label: str | None
    could_be: tuple[str, ...]
    frames: tuple[int, int]
    chance: float
    cause: str

    @property
    def points(self) -> int:
        return self.frames[1] - self.frames[0] + 1

    @property
    def words(self) -> str:
        """What it is, in one line."""
        names = " or ".join(self.could_be)
        if self.label is None:
            return f"no label{f', may be {names}' if names else ''}: {self.cause}"
        return f"may be {names}: {self.cause}" if names else self.cause


def doubt_of(track: Mapping[str, Any], sidecar: Mapping[str, Any]) -> LabelDoubt | None:
    """The doubt about a trajectory of a sidecar; None if there is none."""
    label, confidence, reason = track["label"], track["confidence"], track["reason"]
    if (label is None and reason not in WITHHELD) or (label is not None and confidence >= SURE):
        return None
    first, last = track["frames"]
    chance = confidence if label is not None else 1 - confidence
    seconds = (last - first + 1) / sidecar["rate"]
    cause = TIED if reason == str(Reason.AMBIGUOUS) else _cause(chance, seconds, sidecar)
    return LabelDoubt(label, tuple(track.get("could_be", ())), (first, last), round(chance, 4), cause)


def fits_badly(fit: float | None) -> bool:
    """Whether labels hold so little evidence (`model_fit`) that none of them is to be trusted."""
    return fit is not None and fit < TUNING.poor_fit_below


def troubles_of(sidecar: Mapping[str, Any]) -> list[str]:
    """What is doubtful about all labels of a recording, a sentence each."""
    stats = sidecar.get("stats", {})
    known = sidecar.get("figures", {}).get("doubts", stats.get("doubts", ()))
    said = [f"{text[:1].upper()}{text[1:]}." for text in known]
    fit = stats.get("model_fit")
    if not fits_badly(fit):
        return said
    evidence = f"The labels hold only {fit:.0%} of the usual evidence"
    if not any(track["label"] is not None for track in sidecar["trajectories"]):
        if said:  # which explains it
            return said
        evidence = "No point fits the model"
    return [*said, f"{evidence}: the model may be of another subject, or of markers that were placed anew."]


def _cause(chance: float, seconds: float, sidecar: Mapping[str, Any]) -> str:
    """What keeps a label from being sure: see how `_control` makes confidences."""
    if fits_badly(sidecar.get("stats", {}).get("model_fit")) and chance >= TUNING.poor_fit_share - 1e-3:
        return BADLY
    if sidecar.get("settings", {}).get("rescale"):
        chance /= TUNING.rescaled_share
        if chance >= SURE:
            return ANOTHERS
    return BRIEFLY if _for_a_second(chance, seconds) >= SURE else LOOSELY


def _for_a_second(chance: float, seconds: float) -> float:
    """The chance if the point was seen for a whole second and fitted as well."""
    lacking = -min(math.log10(max(seconds, TUNING.confidence_seconds[0])), 0.0)
    odds = min(chance, 1 - 1e-9) / max(1 - chance, 1e-9) * math.exp(TUNING.confidence_per_decade * lacking)
    return odds / (1 + odds)
