"""Audits of files: what `dshpm-jax check` says about each."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dshpm_jax import io
from dshpm_jax._check import Finding, check
from dshpm_jax._driver import Driver
from dshpm_jax._messages import one_line
from dshpm_jax._reading import Reading, read_aloud
from dshpm_jax._recording import Recording

SHOWN = 5  # labels that the model does not know, in the line about them


@dataclass(frozen=True)
class Audit:
    """What became of one file.

    Attributes:
        sound: whether it was read and nothing was found.
        lines: for people, a line each finding.
        rows: for programs, an entry each finding.
        troubles: what went wrong, or was not judged.
    """

    sound: bool
    lines: list[str] = field(default_factory=list)
    rows: list[dict[str, Any]] = field(default_factory=list)
    troubles: list[str] = field(default_factory=list)


def check_files(paths: Sequence[Path], model_path: Path, how: Reading) -> Iterator[Audit]:
    """Audits files one by one; one that cannot be read harms no other. `how` they are read is as for `io.read`."""
    try:
        model = io.read_model(model_path)
    except io.ReadError as error:
        yield Audit(False, troubles=[str(error)])
        return
    driver = Driver()
    for path in paths:
        try:
            recording = read_aloud(path, how, model.markers)
            yield _audit(path, recording, check(recording, model, driver=driver), model.markers)
        except io.ReadError as error:
            yield Audit(False, troubles=[str(error)])
        except ValueError as error:
            yield Audit(False, troubles=[f"{path}: {error}"])
        except Exception as error:  # memory, say; the other files are none the worse
            yield Audit(False, troubles=[f"{path}: {type(error).__name__}: {one_line(str(error))}"])


def _audit(path: Path, recording: Recording, findings: Sequence[Finding], markers: Sequence[str]) -> Audit:
    offset = io.first_frame(path)
    lines = [_line(path, finding, offset) for finding in findings] or [f"{path}: no wrong label found"]
    named = [name for name, is_name in zip(recording.labels, recording.labelled) if is_name]
    strange = [name for name in named if name not in markers]
    more = ", ..." if len(strange) > SHOWN else ""
    troubles = [f"{path}: not judged, unknown to the model: {', '.join(strange[:SHOWN])}{more}"] if strange else []
    return Audit(not findings, lines, [_row(path, recording, finding, offset) for finding in findings], troubles)


def _line(path: Path, finding: Finding, offset: int) -> str:
    frames = f"frames {finding.first + offset}-{finding.last + offset}"
    if finding.first == finding.last:
        frames = f"frame {finding.first + offset}"
    what = f"should be {finding.should_be}" if finding.should_be else "fits no marker there"
    return (
        f"{path}: {finding.label or 'a column without a name'}, {frames}, {what} (confidence {finding.confidence:.3f})"
    )


def _row(path: Path, recording: Recording, finding: Finding, offset: int) -> dict[str, Any]:
    """Frames as in sidecars, from 0, and as the file itself counts them; the column of the file."""
    return {
        "file": str(path),
        "label": finding.label,
        "column": recording.columns[finding.column],
        "frames": [finding.first, finding.last],
        "file_frames": [finding.first + offset, finding.last + offset],
        "should_be": finding.should_be,
        "confidence": round(finding.confidence, 4),
    }
