"""Runs over files and folders: what is to be labelled with which model, in batches, and where the answers go."""

import dataclasses
import hashlib
import json
import logging
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from dshpm_jax import io
from dshpm_jax._labelling import Labelling
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Settings
from dshpm_jax._subjects import combine_models
from dshpm_jax._types import NO_MATCH
from dshpm_jax.io._atomic import write_whole

MODEL_NAME = "model.json"
MANIFEST_NAME = "manifest.jsonl"
BATCH_FILES = 16
BATCH_BYTES = 256 << 20  # of files in one batch, which bounds the memory of a run

LABELLED, PARTLY, UP_TO_DATE, KEPT, FAILED = "labelled", "partly labelled", "up to date", "kept", "failed"

_log = logging.getLogger(__name__)


class UsageError(ValueError):
    """An order that makes no sense whatever the files hold."""


@dataclass(frozen=True)
class Job:
    """A recording to label.

    Attributes:
        source: the recording.
        target: the labelled file, relative to the folder of the results.
        models: its subjects' models; none where none was found.
        problem: why it cannot be labelled at all, or nothing.
    """

    source: Path
    target: Path
    models: tuple[Path, ...] = ()
    problem: str = ""

    @property
    def sidecar(self) -> Path:
        return self.target.with_name(f"{self.target.stem}.labels.json")


@dataclass(frozen=True)
class Outcome:
    """What became of a job: a row of the manifest."""

    job: Job
    outcome: str
    message: str = ""
    hashes: dict[str, str] = field(default_factory=dict)
    figures: dict[str, Any] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether the folder of the results now holds what was asked for."""
        return self.outcome in (LABELLED, UP_TO_DATE)

    def row(self) -> dict[str, Any]:
        row = {"input": str(self.job.source), "output": self.job.target.as_posix(), "outcome": self.outcome}
        return row | ({"message": self.message} if self.message else {}) | self.hashes | self.figures


def find_jobs(inputs: Sequence[Path], models: Sequence[Path], out: Path) -> list[Job]:
    """Every recording of `inputs`, files or folders (searched recursively), in the order of their names.

    A recording shows the subjects of `models`, or else that of the nearest `model.json` in its folder or above, up to
    the input given.
    Results keep their places relative to the input folder. `out` itself is not searched.
    """
    if out.exists() and not out.is_dir():
        raise UsageError(f"{out}: is a file; give a folder for the results")
    for folder in inputs:
        if folder.is_dir() and folder.resolve() == out.resolve():
            raise UsageError(f"{out}: is an input; give another folder for the results, inside it if you like")
    subjects(models)
    jobs = [job for given in inputs for job in _jobs_of(given, tuple(models), out)]
    jobs = _without_clashes(list({job.source.resolve(): job for job in jobs}.values()))
    originals = {job.source.resolve() for job in jobs}
    for job in jobs:
        if (out / job.target).resolve() in originals:
            raise UsageError(f"{out / job.target}: would overwrite an input; give another folder for the results")
    return jobs


def subjects(models: Sequence[Path]) -> list[str]:
    """What the subjects of several models are called: like the files, or their folders where those are `model.json`."""
    names = [path.stem if path.name != MODEL_NAME else path.resolve().parent.name for path in models]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UsageError(f"two of the models are of a subject called '{twice}'; rename one of the files")
    return names


def label_archive(jobs: Sequence[Job], out: Path, settings: Settings, force: bool = False) -> Iterator[Outcome]:
    """Labels recordings into the folder `out`, and gives their outcomes one by one.

    Files of like size go together, the small ones first. A file that fails harms no other. Results that are there
    and up to date are left alone, other results are overwritten with `force` only, and files that are no results of
    ours never. `out` gets a manifest with a row for each file, whichever run it was labelled in.
    """
    run = _Run(out, settings, force)
    try:
        out.mkdir(parents=True, exist_ok=True)
        rows = _read_manifest(out / MANIFEST_NAME)
        with (out / MANIFEST_NAME).open("a") as manifest:
            for outcome in (outcome for batch in _batches(jobs) for outcome in run.label(batch)):
                row = outcome.row()
                if outcome.outcome != UP_TO_DATE or row["output"] not in rows:
                    rows[row["output"]] = row
                    manifest.write(_row_text(row))
                    manifest.flush()
                yield outcome
        write_whole(out / MANIFEST_NAME, [_row_text(rows[name]).encode() for name in sorted(rows)])
    except OSError as error:
        raise UsageError(f"{out}: cannot be written ({error.strerror}); give another folder for the results") from None


def _jobs_of(given: Path, models: tuple[Path, ...], out: Path) -> list[Job]:
    if not given.is_dir():
        problem = "" if given.exists() else "there is no such file or folder; check the path"
        return [_job(given, Path(given.name), models or _nearest_model(given.parent, given.parent), problem)]
    found = [
        _job(path, path.relative_to(given), models or _nearest_model(path.parent, given))
        for path in _recordings(given, out.resolve())
    ]
    kinds = " or ".join(io.SUFFIXES)
    return found or [Job(given, Path(given.name), (), f"no recordings in this folder; expected files in {kinds}")]


def _job(source: Path, place: Path, models: tuple[Path, ...], problem: str = "") -> Job:
    if not models and not problem:
        problem = f"no {MODEL_NAME} in its folder or above; give --model or make one with 'dshpm-jax model'"
    return Job(source, place.with_name(f"{place.stem}.c3d"), models, problem)


def _recordings(folder: Path, out: Path) -> Iterator[Path]:
    for here, folders, files in os.walk(folder):
        folders[:] = sorted(f for f in folders if not f.startswith(".") and (Path(here) / f).resolve() != out)
        for name in sorted(files):
            if Path(name).suffix.lower() in io.SUFFIXES and not name.startswith("."):
                yield Path(here) / name


def _nearest_model(folder: Path, top: Path) -> tuple[Path, ...]:
    for here in (folder, *folder.parents):
        if (here / MODEL_NAME).is_file():
            return (here / MODEL_NAME,)
        if here == top:
            break
    return ()


def _without_clashes(jobs: list[Job]) -> list[Job]:
    """The jobs with a problem for each whose result would overwrite that of one before it."""
    taken: dict[Path, Path] = {}
    checked = []
    for job in jobs:
        first = taken.setdefault(job.target, job.source)
        clash = f"its result would overwrite that of {first}; rename it or label it into another folder"
        checked.append(job if first == job.source else dataclasses.replace(job, problem=job.problem or clash))
    return checked


def _read_manifest(path: Path) -> dict[str, dict[str, Any]]:
    """The last row of each result; lines that a killed run left unfinished are passed over."""
    rows = {}
    for line in path.read_text().splitlines() if path.exists() else ():
        try:
            row = json.loads(line)
            rows[row["output"]] = row
        except (ValueError, TypeError, KeyError):
            _log.debug("%s holds a line that is no row: %s", path, line)
    return rows


def _row_text(row: dict[str, Any]) -> str:
    return json.dumps(row, default=_plain) + "\n"


def _batches(jobs: Sequence[Job]) -> Iterator[list[Job]]:
    """Recordings of like size together, so that little of a batch is padding."""
    sizes = {job: job.source.stat().st_size if job.source.is_file() else 0 for job in jobs}
    batch: list[Job] = []
    for job in sorted(jobs, key=lambda job: (sizes[job], str(job.source))):
        if batch and (len(batch) == BATCH_FILES or sum(sizes[b] for b in batch) + sizes[job] > BATCH_BYTES):
            yield batch
            batch = []
        batch.append(job)
    if batch:
        yield batch


@dataclass(frozen=True)
class _Loaded:
    job: Job
    recording: Recording
    model: SubjectModel
    hashes: dict[str, str]


class _Run:
    """What all batches of a run share."""

    def __init__(self, out: Path, settings: Settings, force: bool):
        self.out, self.settings, self.force = out, settings, force
        self.settings_hash = _hash(json.dumps([version("dshpm-jax"), dataclasses.asdict(settings)]).encode())
        self.models: dict[tuple[Path, ...], tuple[SubjectModel, str]] = {}

    def label(self, batch: Sequence[Job]) -> Iterator[Outcome]:
        loaded: list[_Loaded] = []
        for job in batch:
            try:
                ready = self._load(job)
            except Exception as error:
                ready = _failed(job, error)
            if isinstance(ready, Outcome):
                yield ready
            else:
                loaded.append(ready)
        for item, answer in zip(loaded, self._answers(loaded), strict=True):
            yield self._keep(item, answer) if isinstance(answer, Labelling) else _failed(item.job, answer, item.hashes)

    def _load(self, job: Job) -> _Loaded | Outcome:
        """Reads a job's files, or finds that there is nothing to do."""
        if job.problem or not job.models:
            return Outcome(job, FAILED, f"{job.source}: {job.problem}")
        model, model_hash = self._model(job.models)
        hashes = {"sha256": _hash_file(job.source), "settings": self.settings_hash, "model": model_hash}
        target, head = self.out / job.target, io.read_sidecar_head(self.out / job.sidecar)
        if target.exists() and head is None:
            what = "is there and none of our results, not overwritten"
            remedy = "move it away or give another folder for the results"
            return Outcome(job, KEPT, f"{target}: {what}; {remedy}", hashes)
        if target.exists() and head is not None and not self.force:
            if head.get("hashes") == hashes:
                return Outcome(job, UP_TO_DATE, hashes=hashes)
            what = "is there, from another input, model or settings, not overwritten"
            return Outcome(job, KEPT, f"{target}: {what}; say --force to do so", hashes)
        return _Loaded(job, io.read(job.source), model, hashes)

    def _model(self, paths: tuple[Path, ...]) -> tuple[SubjectModel, str]:
        """The model of the subjects of `paths`, and a hash that tells it from others."""
        if paths not in self.models:
            found, hashes = [io.read_model(path) for path in paths], [_hash_file(path) for path in paths]
            if len(paths) == 1:
                self.models[paths] = found[0], hashes[0]
            else:
                names = subjects(paths)
                told = _hash(json.dumps([names, hashes]).encode())
                self.models[paths] = combine_models(dict(zip(names, found))), told
        return self.models[paths]

    def _answers(self, loaded: Sequence[_Loaded]) -> Iterator[Labelling | Exception]:
        """Labels a batch together; where that raises, what is left of it one by one."""
        if not loaded:
            return
        from dshpm_jax._label import label_many  # jax is slow to start, and not needed before

        done = 0
        try:
            for answer in label_many([i.recording for i in loaded], [i.model for i in loaded], self.settings):
                yield answer
                done += 1
        except Exception:
            _log.debug("a batch failed, its recordings go one by one", exc_info=True)
        for item in loaded[done:]:
            try:
                yield next(iter(label_many([item.recording], [item.model], self.settings)))
            except Exception as error:
                yield error

    def _keep(self, item: _Loaded, labelling: Labelling) -> Outcome:
        """Writes the results of one recording."""
        job, target = item.job, self.out / item.job.target
        record = {"hashes": item.hashes, "settings": dataclasses.asdict(self.settings)}
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            # A run that is killed leaves no result beside a sidecar that does not belong to it.
            target.unlink(missing_ok=True)
            io.write_sidecar(labelling, self.out / job.sidecar, record)
            io.write_labelled(labelling, target)
        except Exception as error:
            if not target.exists():
                (self.out / job.sidecar).unlink(missing_ok=True)
            return _failed(job, error, item.hashes)
        figures = _figures(labelling)
        share = figures["completeness"]
        if share < self.settings.completeness:
            message = f"{job.source}: only {share:.1%} of its markers found; check that {_list(job.models)} is right"
            return Outcome(job, PARTLY, message, item.hashes, figures)
        return Outcome(job, LABELLED, "", item.hashes, figures)


def _figures(labelling: Labelling) -> dict[str, Any]:
    recording = labelling.recording
    labelled = int((labelling.identities != NO_MATCH).sum())
    return {
        "frames": recording.num_frames,
        "points": int(recording.present.sum()),
        "labelled_points": labelled,
        "trajectories": len(labelling.trajectories),
        "labelled_trajectories": int((labelling.identity != NO_MATCH).sum()),
        "completeness": round(labelled / max(1, recording.num_frames * labelling.model.num_markers), 4),
        "stats": labelling.stats,
    }


def _list(models: Sequence[Path]) -> str:
    return " and ".join(map(str, models))


def _failed(job: Job, error: Exception, hashes: dict[str, str] | None = None) -> Outcome:
    """The outcome of a job that raised, in one line that names the file."""
    _log.debug("%s failed", job.source, exc_info=error)
    text = " ".join(str(error).split())
    if not isinstance(error, ValueError):  # nothing that we foresaw
        text = f"{type(error).__name__}: {text}"
    named = text if isinstance(error, io.ReadError | io.WriteError) else f"{job.source}: {text}"
    return Outcome(job, FAILED, named, hashes or {})


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _hash_file(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)
