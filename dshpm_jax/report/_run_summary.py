"""What a run over an archive gave, from its manifest and sidecars: by trial, by subject, by label."""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dshpm_jax import io
from dshpm_jax._corrections import CorrectionsError, corrections_path, read_corrections
from dshpm_jax.report._doubts import CAUSES, SURE, LabelDoubt, doubt_of
from dshpm_jax.report._run_rows import listed, severity, trial_row
from dshpm_jax.report._totals import LEAST_CONFIDENCE, MarkerTotals, Stretch, TrialTotals, share
from dshpm_jax.report._worst import Worst

# Bytes of a page, which is at most 5 MB whatever the archive's size.
TRIAL_BYTES, DOUBT_BYTES, SUBJECT_BYTES, MARKER_BYTES = 2_700_000, 1_200_000, 300_000, 300_000


@dataclass
class RunSummary:
    """Grows by a row of the manifest and its sidecar at a time, and never far beyond what a page can hold."""

    out: Path
    all: TrialTotals = field(default_factory=TrialTotals)
    subjects: dict[str, TrialTotals] = field(default_factory=dict)
    markers: dict[str, MarkerTotals] = field(default_factory=dict)
    trials: Worst = field(default_factory=lambda: Worst(TRIAL_BYTES))
    doubts: Worst = field(default_factory=lambda: Worst(DOUBT_BYTES))

    def add(self, row: Mapping[str, Any]) -> None:
        """Counts one trial; what its row or sidecar does not say stays empty."""
        output = row.get("output")  # None if another recording has the place of its result
        result = self.out / output if output else None
        labelled = "completeness" in row or not row.get("message")
        found = io.read_sidecar(io.sidecar_path(result), column_runs=False) if result and labelled else None
        tracks = found["trajectories"] if found else []
        doubts = [doubt for track in tracks if (doubt := doubt_of(track, found or {}))]
        stake = sum(doubt.points for doubt in doubts) / found["rate"] if found else 0.0
        sure, name = _mean_confidence(tracks), output or str(row.get("input"))
        for totals in (self.all, self.subjects.setdefault(os.path.dirname(name), TrialTotals())):
            totals.add(row, sure, len(doubts), stake)
        key = (severity(row), -stake, name)
        self.trials.add(key, trial_row(name, row, (stake, len(doubts), sure), self.out, tracks, _confirmed(result)))
        if found:
            self._count_labels(found, doubts)
        if found and doubts:
            self.doubts.add(key, [name, listed(doubts, found["rate"])])

    def data(self) -> dict[str, Any]:
        """All of it as the page's script takes it."""
        subjects, markers = Worst(SUBJECT_BYTES), Worst(MARKER_BYTES)
        for name, totals in self.subjects.items():
            subjects.add((-totals.stake, name), {"name": name, **totals.data()})
        for label, totals in self.markers.items():
            markers.add((totals.found / max(totals.frames, 1), label), totals.row(label))
        return {
            "sure": SURE,
            "causes": CAUSES,
            "all": {**self.all.data(), "sums": {key: round(value, 2) for key, value in self.all.sums.items()}},
            "histograms": {"completeness": self.all.completeness, "confidence": self.all.confidence},
            "least_confidence": LEAST_CONFIDENCE,
            "trials": self.trials.entries(),
            "doubts": dict(self.doubts.entries()),
            "subjects": subjects.entries(),
            "all_subjects": len(self.subjects),
            "markers": markers.entries(),
            "all_markers": len(self.markers),
        }

    def _count_labels(self, sidecar: Mapping[str, Any], doubts: Iterable[LabelDoubt]) -> None:
        stretches: dict[str, list[Stretch]] = {label: [] for label in sidecar["markers"]}
        for track in sidecar["trajectories"]:
            if track["label"] is not None:
                stretches.setdefault(track["label"], []).append((*track["frames"], track["confidence"]))
        for label, parts in stretches.items():
            self.markers.setdefault(label, MarkerTotals()).add(parts, sidecar["frames"], sidecar["rate"])
        for doubt in doubts:
            label = doubt.label or next(iter(doubt.could_be), None)
            if label in stretches:
                self.markers[label].stake += doubt.points / sidecar["rate"]


def _confirmed(result: Path | None) -> bool:
    """Whether a person has confirmed a result; a damaged file of corrections says nothing here."""
    try:
        found = read_corrections(corrections_path(result)) if result else None
    except CorrectionsError:
        return False
    return found is not None and found.confirmed


def summarise(out: Path, rows: Iterable[Mapping[str, Any]]) -> RunSummary:
    """The summary of the results in the folder `out`, a row of the manifest each."""
    summary = RunSummary(out)
    for row in rows:
        summary.add(row)
    return summary


def _mean_confidence(tracks: Sequence[Mapping[str, Any]]) -> float | None:
    """Of the labels given, weighted by the frames that carry them."""
    named = [(t["frames"][1] - t["frames"][0] + 1, t["confidence"]) for t in tracks if t["label"] is not None]
    return share(sum(n * c for n, c in named), sum(n for n, _ in named))
