"""The command `check`: what it says about the labels that recordings have."""

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dshpm_jax import io
from dshpm_jax._commands.statuses import FAILURES, OK
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._console import add_reading, complain, say
from dshpm_jax._messages import UsageError, one_line
from dshpm_jax._reading import Reading, read_aloud, reading
from dshpm_jax._recording import Recording
from dshpm_jax._size import SIZE_REMEDY, size_doubt
from dshpm_jax.io._atomic import write_whole

if TYPE_CHECKING:
    from dshpm_jax._check import Finding

ABOUT = "audits the labels that recordings have"
SHOWN = 5  # labels that the model does not know, in the line about them


@dataclass(frozen=True)
class _Audit:
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


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of `check`."""
    parser.add_argument("recordings", nargs="+", type=Path, metavar="RECORDING", help="labelled recording")
    parser.add_argument("--model", type=Path, required=True, metavar="MODEL", help="model of the subject")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write what was found there too")
    add_reading(parser)


def run(arguments: argparse.Namespace) -> int:
    """Audits files and gives the exit status: 1 if something was found, or some could not be audited."""
    if not arguments.model.is_file():
        raise UsageError(f"{arguments.model}: there is no such model; make one with 'dshpm-jax model'")
    if arguments.json and (arguments.json.suffix != ".json" or not arguments.json.parent.is_dir()):
        raise UsageError(f"{arguments.json}: no place for the findings; give a .json file in a folder that is there")
    if arguments.json and not _may_be_findings(arguments.json):
        raise UsageError(f"{arguments.json}: is there and holds no findings, not overwritten; give another file")
    cache_programs()
    rows, good = [], True
    for found in _audits(arguments.recordings, arguments.model, reading(arguments)):
        good &= found.sound
        rows += found.rows
        for line in found.troubles:
            complain(line)
        for line in found.lines:
            say(line)
    if arguments.json:
        good &= _written(rows, arguments.json)
    return OK if good else FAILURES


def _audits(paths: Sequence[Path], model_path: Path, how: Reading) -> Iterator[_Audit]:
    """Audits files one by one; one that cannot be read harms no other. `how` they are read is as for `io.read`."""
    try:
        model = io.read_model(model_path)
    except io.ReadError as error:
        yield _Audit(False, troubles=[str(error)])
        return
    from dshpm_jax._check import check  # imports jax
    from dshpm_jax._driver import Driver

    driver = Driver()
    for path in paths:
        try:
            recording = read_aloud(path, how, model.markers)
            if doubt := size_doubt(recording, model):
                yield _Audit(False, troubles=[f"{path}: no label could be confirmed, as {doubt}; {SIZE_REMEDY}"])
                continue
            yield _audit(path, recording, check(recording, model, driver=driver), model.markers)
        except io.ReadError as error:
            yield _Audit(False, troubles=[str(error)])
        except ValueError as error:
            yield _Audit(False, troubles=[f"{path}: {error}"])
        except Exception as error:  # memory, say; the other files are none the worse
            yield _Audit(False, troubles=[f"{path}: {type(error).__name__}: {one_line(str(error))}"])


def _audit(path: Path, recording: Recording, findings: Sequence["Finding"], markers: Sequence[str]) -> _Audit:
    offset = io.first_frame(path)
    lines = [_line(path, finding, offset) for finding in findings] or [f"{path}: no wrong label found"]
    named = [name for name, is_name in zip(recording.labels, recording.labelled) if is_name]
    strange = [name for name in named if name not in markers]
    more = ", ..." if len(strange) > SHOWN else ""
    troubles = [f"{path}: not judged, unknown to the model: {', '.join(strange[:SHOWN])}{more}"] if strange else []
    return _Audit(not findings, lines, [_row(path, recording, finding, offset) for finding in findings], troubles)


def _line(path: Path, finding: "Finding", offset: int) -> str:
    frames = f"frames {finding.first + offset}-{finding.last + offset}"
    if finding.first == finding.last:
        frames = f"frame {finding.first + offset}"
    what = f"should be {finding.should_be}" if finding.should_be else "fits no marker there"
    return f"{path}: {finding.label or 'a column without a name'}, {frames}, {what} (evidence {finding.evidence:.0f})"


def _row(path: Path, recording: Recording, finding: "Finding", offset: int) -> dict[str, Any]:
    """Frames as in sidecars, from 0, and as the file itself counts them; the column of the file."""
    return {
        "file": str(path),
        "label": finding.label,
        "column": recording.columns[finding.column],
        "frames": [finding.first, finding.last],
        "file_frames": [finding.first + offset, finding.last + offset],
        "should_be": finding.should_be,
        "evidence": round(finding.evidence, 2),
    }


def _may_be_findings(path: Path) -> bool:
    """Whether the findings may be written to `path`: nothing is there, or findings of an earlier run."""
    if not path.exists():
        return True
    try:
        rows = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return False
    return isinstance(rows, list) and all(isinstance(row, dict) and "should_be" in row for row in rows)


def _written(rows: Sequence[object], path: Path) -> bool:
    try:
        write_whole(path, [(json.dumps(rows, indent=1) + "\n").encode()])
    except OSError as error:
        complain(f"{path}: cannot be written ({error.strerror}); give another file")
        return False
    return True
