"""What is to be labelled, with which model, and where the answer goes."""

import dataclasses
import hashlib
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._geometry import evenly_spaced
from dshpm_jax._messages import UsageError
from dshpm_jax.io._form import AS_IT_IS, Form

MODEL_NAME = "model.json"
SUMMARY_NAME = "summary.csv"  # of a run, in the folder of its results
FORMATS = C3D, TRC, SAME = "c3d", "trc", "same"  # of results

MOST_BESIDE = 6
"""count; used in `with_those_beside`: recordings of a folder by which the model of its subject is found; by hand: each
takes as long as labelling it, and sizes are known after a few."""


@dataclass(frozen=True)
class Job:
    """A recording to label.

    Attributes:
        source: the recording.
        target: the labelled file, relative to the folder of the results.
        models: its subjects' models; none where none was found.
        problem: why it cannot be labelled at all, or nothing.
        clashes: whether `target` is the result of another recording.
        page: whether a page in which it plays is made with the result.
        beside: where it is labelled by a marker set, recordings of the same subject by which their model is found,
            itself included; none where each recording stands for a subject of its own.
        form: how the result is written, besides its format.
    """

    source: Path
    target: Path
    models: tuple[Path, ...] = ()
    problem: str = ""
    clashes: bool = False
    page: bool = False
    beside: tuple[Path, ...] = ()
    form: Form = AS_IT_IS

    @property
    def sidecar(self) -> Path:
        return self.target.with_name(f"{self.target.stem}.labels.json")


def find_jobs(
    inputs: Sequence[Path], models: Sequence[Path], out: Path, kind: str = C3D, form: Form = AS_IT_IS
) -> list[Job]:
    """Every recording of `inputs`, files or folders (searched recursively), in the order of their names.

    A recording shows the subjects of `models`, or else that of the nearest `model.json` in its folder or above, up to
    the input given.
    Results keep their places relative to the input folder. `out` itself is not searched.

    Arguments:
        kind: the format of results: `C3D`, `TRC`, or `SAME` for that of each recording.
    """
    if out.exists() and not out.is_dir():
        raise UsageError(f"{out}: is a file; give a folder for the results")
    for folder in inputs:
        if folder.is_dir() and folder.resolve() == out.resolve():
            raise UsageError(f"{out}: is an input; give another folder for the results, inside it if you like")
    subjects(models)
    jobs = [job for given in inputs for job in _jobs_of(given, tuple(models), out)]
    jobs = [_in_form(job, kind, form) for job in jobs]
    own = _once_each(jobs)
    jobs, originals = _without_clashes(list(own.values())), own.keys()
    for place in (*(job.target for job in jobs), SUMMARY_NAME):
        if (out / place).resolve() in originals:
            raise UsageError(f"{out / place}: would overwrite an input; give another folder for the results")
    return with_those_beside([_beside_the_summary(job) for job in jobs])


def with_those_beside(jobs: Sequence[Job]) -> list[Job]:
    """The jobs that are labelled by a marker set, with the recordings by which their subject's model is found.

    These are spread evenly over all of one folder with one set whose results lie together, in the order of their names.
    """
    sets = {models for models in {job.models for job in jobs} if len(models) == 1 and io.is_marker_set(models[0])}
    groups: dict[tuple, list[Path]] = {}
    for job in jobs:
        if job.models in sets and not job.problem:
            groups.setdefault(_subject_of(job), []).append(job.source)
    for key, sources in groups.items():
        ordered = sorted(sources)
        groups[key] = [ordered[k] for k in evenly_spaced(len(ordered), MOST_BESIDE)]
    return [dataclasses.replace(job, beside=tuple(groups.get(_subject_of(job), ()))) for job in jobs]


def _subject_of(job: Job) -> tuple:
    return job.models, job.source.parent, job.target.parent


def _in_form(job: Job, kind: str, form: Form) -> Job:
    """The job with its result in a format, and a problem where nobody can write it so."""
    if job.target.suffix != f".{C3D}":  # it stands for a folder
        return job
    suffix = job.source.suffix if kind == SAME else f".{kind}"
    problem = ""
    if form.changes_points and suffix.lower() not in (f".{C3D}", f".{TRC}"):
        problem = f"axes and units are changed in C3D and TRC alone; give --format {TRC}"
    return dataclasses.replace(job, target=job.target.with_suffix(suffix), form=form, problem=job.problem or problem)


def _beside_the_summary(job: Job) -> Job:
    """The job with a problem where its result would have the name of the run's summary."""
    if job.target != Path(SUMMARY_NAME):
        return job
    problem = f"its result would overwrite {SUMMARY_NAME} of the run; rename it"
    return dataclasses.replace(job, problem=job.problem or problem, clashes=True)


def subjects(models: Sequence[Path]) -> list[str]:
    """What the subjects of several models are called: like the files, or their folders where those are `model.json`."""
    names = [path.stem if path.name != MODEL_NAME else path.resolve().parent.name for path in models]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UsageError(f"two of the models are of a subject called '{twice}'; rename one of the files")
    return names


def in_shard(jobs: Sequence[Job], shard: tuple[int, int]) -> list[Job]:
    """The jobs of shard `i` of `n`: which one a job is in depends on its result's name alone, not on other files."""
    i, n = shard
    return [job for job in jobs if int(hashlib.sha256(os.fsencode(job.sidecar.as_posix())).hexdigest(), 16) % n == i]


def _jobs_of(given: Path, models: tuple[Path, ...], out: Path) -> list[Job]:
    if not given.is_dir():
        problem = "" if given.exists() else "there is no such file or folder; check the path"
        return [_job(given, Path(given.name), models or _nearest_model(given.parent, given.parent), problem)]
    closed: list[OSError] = []
    found = [
        _job(path, path.relative_to(given), models or _nearest_model(path.parent, given))
        for path in _recordings(given, out.resolve(), closed)
    ]
    found += [_closed(error, given) for error in closed]
    kinds = " or ".join(io.SUFFIXES)
    return found or [Job(given, Path(given.name), (), f"no recordings in this folder; expected files in {kinds}")]


def _job(source: Path, place: Path, models: tuple[Path, ...], problem: str = "") -> Job:
    if not models and not problem:
        problem = f"no {MODEL_NAME} in its folder or above; give --model or make one with 'dshpm-jax model'"
    return Job(source, place.with_name(f"{place.stem}.c3d"), models, problem)


def _closed(error: OSError, given: Path) -> Job:
    """Stands for whatever is in a folder that cannot be searched."""
    folder = Path(error.filename)
    place = folder.relative_to(given) if folder != given else Path(given.name)
    return Job(folder, place, (), f"this folder cannot be searched ({error.strerror}); check its permissions")


def _recordings(folder: Path, out: Path, closed: list[OSError]) -> Iterator[Path]:
    """What may be recordings, folder by folder; linked folders last, unless they lead to what is searched anyway."""
    tops, searched = [folder], []
    for top in tops:
        real = top.resolve()
        if top != folder and any(real.is_relative_to(x) or x.is_relative_to(real) for x in (*searched, out)):
            continue
        searched.append(real)
        for here, folders, files in os.walk(top, onerror=closed.append):
            inside = [Path(here) / name for name in sorted(folders) if not name.startswith(".")]
            tops += [path for path in inside if path.is_symlink()]  # os.walk lists links but does not follow them
            folders[:] = [path.name for path in inside if path.resolve() != out]
            for name in sorted(files):
                if not name.startswith(".") and io.may_be_recording(Path(here) / name):
                    yield Path(here) / name


def _nearest_model(folder: Path, top: Path) -> tuple[Path, ...]:
    for here in (folder, *folder.parents):
        if (here / MODEL_NAME).is_file():
            return (here / MODEL_NAME,)
        if here == top:
            break
    return ()


def _once_each(jobs: Iterable[Job]) -> dict[Path, Job]:
    """The jobs by the files that they are of; of several, the first that is not by a link to the file counts."""
    own: dict[Path, Job] = {}
    for job in jobs:
        real = job.source.resolve()
        if real not in own or (own[real].source.is_symlink() and not job.source.is_symlink()):
            own[real] = job
    return own


def _without_clashes(jobs: list[Job]) -> list[Job]:
    """The jobs with a problem for each whose result or sidecar would overwrite that of one before it."""
    taken: dict[Path, Path] = {}
    checked = []
    for job in jobs:
        first = taken.setdefault(job.sidecar, job.source)
        if first != job.source:
            clash = f"its result would overwrite that of {first}; rename it or label it into another folder"
            job = dataclasses.replace(job, problem=job.problem or clash, clashes=True)
        checked.append(job)
    return checked
