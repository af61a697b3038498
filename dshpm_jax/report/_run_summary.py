"""What a run over an archive gave, from its manifest and sidecars: by file, by label, and which labels to look at."""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote

from dshpm_jax import io
from dshpm_jax._labelling import Reason
from dshpm_jax.report._page import is_page

SURE = 0.9
"""Labels less sure than this are listed, with those withheld because two labels fit almost equally well."""

MAX_SUSPECTS = 1000  # listed, those with most at stake; the page says how many there are


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

    def add(self, stretches: Sequence[tuple[int, int, float]], frames: int, rate: float) -> None:
        """Counts one recording: first and last frame and confidence of every stretch that carries the label."""
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
            "found": _rounded(self.found, self.frames),
            "confidence": _rounded(self.sureness, self.found),
            "gaps": self.gaps,
            "longest": round(self.longest, 3),
        }


@dataclass
class RunSummary:
    """Grows by a row of the manifest and its sidecar at a time."""

    files: list[dict[str, Any]] = field(default_factory=list)
    suspects: list[dict[str, Any]] = field(default_factory=list)
    markers: dict[str, MarkerTotals] = field(default_factory=dict)

    def add(self, out: Path, row: Mapping[str, Any]) -> None:
        """Counts one file; what its row or sidecar does not say stays empty."""
        output = row.get("output")  # None if another recording has the place of its result
        result = out / output if output else None
        labelled = "completeness" in row or not row.get("message")
        found = io.read_sidecar(io.sidecar_path(result), column_runs=False) if result and labelled else None
        tracks = found["trajectories"] if found else []
        suspects = [track for track in tracks if _suspect(track)]
        number = len(self.files)
        self.files.append(
            {
                **{key: row.get(key) for key in ("input", "outcome", "message", "completeness", "frames")},
                **{key: row.get(key) for key in ("trajectories", "labelled_trajectories", "seconds")},
                "name": output or row.get("input"),
                "confidence": _mean_confidence(tracks),
                "suspects": len(suspects) if found else None,
                "link": _link(out, result),
                "page": _link(out, _page_of(result) if result else None),
            }
        )
        self.suspects += [_suspect_row(number, track, found["rate"]) for track in suspects if found]
        if found:
            stretches: dict[str, list[tuple[int, int, float]]] = {label: [] for label in found["markers"]}
            for track in tracks:
                if track["label"] is not None:
                    stretches.setdefault(track["label"], []).append((*track["frames"], track["confidence"]))
            for label, parts in stretches.items():
                self.markers.setdefault(label, MarkerTotals()).add(parts, found["frames"], found["rate"])

    def data(self) -> dict[str, Any]:
        """All of it as the page's script takes it."""
        # By the seconds that are expected to be wrong, or unlabelled though they should not be.
        most_at_stake = sorted(self.suspects, key=lambda s: (-s["stake"], s["file"], s["first"]))
        return {
            "sure": SURE,
            "files": self.files,
            "suspects": most_at_stake[:MAX_SUSPECTS],
            "all_suspects": len(self.suspects),
            "markers": [totals.row(label) for label, totals in self.markers.items()],
        }


def summarise(out: Path, rows: Iterable[Mapping[str, Any]]) -> RunSummary:
    """The summary of the results in the folder `out`, a row of the manifest each."""
    summary = RunSummary()
    for row in rows:
        summary.add(out, row)
    return summary


def _suspect(track: Mapping[str, Any]) -> bool:
    return track["confidence"] < SURE if track["label"] is not None else track["reason"] == str(Reason.AMBIGUOUS)


def _suspect_row(number: int, track: Mapping[str, Any], rate: float) -> dict[str, Any]:
    first, last = track["frames"]
    seconds = (last - first + 1) / rate
    return {
        "file": number,
        "label": track["label"],
        "first": first,
        "last": last,
        "seconds": round(seconds, 3),
        "confidence": track["confidence"],
        "stake": round((1 - track["confidence"]) * seconds, 4),
        "reason": track["reason"],
        "could_be": track.get("could_be", []),
    }


def _mean_confidence(tracks: Sequence[Mapping[str, Any]]) -> float | None:
    """Of the labels given, weighted by the frames that carry them."""
    named = [(t["frames"][1] - t["frames"][0] + 1, t["confidence"]) for t in tracks if t["label"] is not None]
    return _rounded(sum(n * c for n, c in named), sum(n for n, _ in named))


def _rounded(part: float, whole: float) -> float | None:
    return round(part / whole, 4) if whole else None


def _page_of(result: Path) -> Path | None:
    """The page that `view` made of a result, unless that was labelled again since."""
    page = result.with_suffix(".html")
    return page if is_page(page) and page.stat().st_mtime >= result.stat().st_mtime else None


def _link(out: Path, file: Path | None) -> str | None:
    """A link from `out` to a file, whatever its name holds; None if it is not there."""
    return quote(os.fsencode(file.relative_to(out).as_posix())) if file and file.is_file() else None
