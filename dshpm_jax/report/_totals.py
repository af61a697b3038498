"""Totals over a run: of each label, of each subject's folder, of all trials."""

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

BINS = 20  # of a histogram
LEAST_CONFIDENCE = 0.8  # of its histogram; those below count in the first bin

Stretch = tuple[int, int, float]
"""First and last frame and confidence of a trajectory."""


@dataclass
class MarkerTotals:
    """What a run says of one label. Seconds and shares are over the recordings whose model has it."""

    files: int = 0
    absent: int = 0  # files in which it was never found
    frames: int = 0
    found: int = 0  # frames with the label
    sureness: float = 0.0  # sum of the confidences of those frames
    gaps: int = 0  # breaks between two stretches in which it was found
    longest: float = 0.0  # seconds
    stake: float = 0.0  # seconds of points that have the label, or from which it is withheld, and are in doubt

    def add(self, stretches: Sequence[Stretch], frames: int, rate: float) -> None:
        """Counts one recording by the stretches that carry the label."""
        self.files += 1
        self.absent += not stretches
        self.frames += frames
        last = None
        for first, end, confidence in sorted(stretches):
            length = end - first + 1
            self.found += length
            self.sureness += length * confidence
            if last is not None and first > last + 1:
                self.gaps += 1
                self.longest = max(self.longest, (first - last - 1) / rate)
            last = end

    def row(self, label: str) -> dict[str, Any]:
        return {
            "label": label,
            "files": self.files,
            "absent": self.absent,
            "found": share(self.found, self.frames),
            "confidence": share(self.sureness, self.found),
            "gaps": self.gaps,
            "longest": round(self.longest, 3),
            "stake": round(self.stake, 2),
        }


@dataclass
class TrialTotals:
    """What a run says of many trials, of one subject or of all."""

    trials: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    sums: dict[str, float] = field(default_factory=lambda: defaultdict(float))  # of what rows of the manifest count
    doubts: int = 0
    stake: float = 0.0  # seconds
    completeness: list[int] = field(default_factory=lambda: [0] * BINS)  # trials by completeness
    confidence: list[int] = field(default_factory=lambda: [0] * BINS)

    def add(self, row: Mapping[str, Any], confidence: float | None, doubts: int, stake: float) -> None:
        self.trials += 1
        self.outcomes[str(row.get("outcome"))] += 1
        for key in ("frames", "trajectories", "labelled_trajectories", "points", "labelled_points", "seconds"):
            self.sums[key] += row.get(key) or 0
        self.doubts += doubts
        self.stake += stake
        if row.get("completeness") is not None:
            self.completeness[_bin(row["completeness"], 0.0)] += 1
            self.sums["completeness"] += row["completeness"]
        if confidence is not None:
            self.confidence[_bin(confidence, LEAST_CONFIDENCE)] += 1
            self.sums["confidence"] += confidence

    def data(self) -> dict[str, Any]:
        return {
            "trials": self.trials,
            "outcomes": dict(self.outcomes),
            "doubts": self.doubts,
            "stake": round(self.stake, 2),
            "completeness": share(self.sums["completeness"], sum(self.completeness)),
            "confidence": share(self.sums["confidence"], sum(self.confidence)),
        }


def share(part: float, whole: float) -> float | None:
    return round(part / whole, 4) if whole else None


def _bin(value: float, low: float) -> int:
    return min(max(int((value - low) / (1 - low) * BINS + 1e-9), 0), BINS - 1)
