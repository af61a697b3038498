"""Labels a batch of recordings and writes each result as it comes; runs in any process that sees the files."""

import dataclasses
import logging
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dshpm_jax._archive.compiling import notice_of_compiling
from dshpm_jax._archive.hashes import INPUT, MODEL, SETTINGS, hash_file, hash_form, hash_settings, read_models
from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.outcomes import Outcome, failed, figures_of, judged, passed_over, without_points
from dshpm_jax._archive.own_models import member_of
from dshpm_jax._archive.results import ResultKept, write_result
from dshpm_jax._archive.said import Said, said_about
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._given import recording_of
from dshpm_jax._labelling import Labelling
from dshpm_jax._marker_set import MarkerSet, Member
from dshpm_jax._model import SubjectModel
from dshpm_jax._outcomes import KEPT
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Settings
from dshpm_jax._types import NO_MATCH

Notice = Callable[[str], object]
"""Takes a line about what is going on."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Loaded:
    job: Job
    recording: Recording
    model: SubjectModel | MarkerSet | Member
    hashes: dict[str, str]
    said: Said


def label_batch(jobs: Sequence[Job], out: Path, settings: Settings, notice: Notice) -> Iterator[Outcome]:
    """Labels recordings side by side, and gives each outcome when its result is written; one that fails harms no other.

    Nothing but the outcomes goes to whoever asked.
    """
    notice(f"reading {_files(len(jobs))}")
    models: dict[tuple[Path, ...], tuple[SubjectModel | MarkerSet, str]] = {}
    loaded: list[_Loaded] = []
    watch = _Watch()
    for job in jobs:
        try:
            if job.models not in models:
                models[job.models] = read_models(job.models)
            loaded.append(_load(job, *models[job.models], out, settings))
        except Exception as error:
            yield passed_over(job, error) if without_points(error) else failed(job, error)
    frames = [item.recording.num_frames for item in loaded]
    for k, answer in enumerate(_answers(loaded, settings, notice)):
        item = loaded[k]
        if isinstance(answer, Labelling):
            outcome = _keep(item, answer, out, settings)
        else:
            outcome = failed(item.job, answer, item.hashes)
        seconds = watch.share(frames[k:]) if outcome.figures else None
        yield dataclasses.replace(outcome, notes=_notes(item, answer), seconds=seconds)


def label_batch_telling(
    jobs: Sequence[Job], out: Path, settings: Settings, tell: Callable[[Outcome | str], object]
) -> list[Outcome]:
    """The same at once, for a process that tells another of each outcome, and of what is going on."""
    outcomes = []
    for outcome in label_batch(jobs, out, settings, tell):
        tell(outcome)
        outcomes.append(outcome)
    return outcomes


def _files(count: int) -> str:
    return "1 file" if count == 1 else f"{count} files"


class _Watch:
    """Shares out time among recordings that are labelled side by side, by their frames."""

    def __init__(self) -> None:
        self._last = time.perf_counter()
        self._per_frame = 0.0  # seconds of those that have been in flight all the time

    def share(self, frames: Sequence[int]) -> float:
        """The share of the first of those in flight, which ends now."""
        now = time.perf_counter()
        self._per_frame += (now - self._last) / max(1, sum(frames))
        self._last = now
        return round(self._per_frame * frames[0], 3)


def _load(job: Job, model: SubjectModel | MarkerSet, model_hash: str, out: Path, settings: Settings) -> _Loaded:
    # Hashed before it is read: if it changes meanwhile, the hash after labelling is another.
    hashes = {INPUT: hash_file(job.source), SETTINGS: hash_settings(settings), MODEL: model_hash, **hash_form(job.form)}
    recording = recording_of(job.source, model, settings)
    said = said_about(job, out, recording, model.markers)
    if isinstance(model, MarkerSet) and job.beside:
        return _Loaded(job, recording, member_of(job, model, model_hash, out, settings), hashes, said)
    return _Loaded(job, recording, model, hashes, said)


def _answers(loaded: Sequence[_Loaded], settings: Settings, notice: Notice) -> Iterator[Labelling | Exception]:
    """Labels a batch together; where that raises, what is left of it one by one."""
    if not loaded:
        return
    notice(f"labelling {_files(len(loaded))}")
    with notice_of_compiling(notice):
        cache_programs()
        from dshpm_jax._label import label_many  # jax is slow to start, and not needed before

        done = 0
        try:
            recordings, models = [i.recording for i in loaded], [i.model for i in loaded]
            for answer in label_many(recordings, models, settings, known=[i.said.known for i in loaded]):
                yield answer
                done += 1
        except Exception:
            _log.debug("a batch failed, its recordings go one by one", exc_info=True)
        for item in loaded[done:]:
            try:
                yield next(label_many([item.recording], [item.model], settings, known=[item.said.known]))
            except Exception as error:
                yield error


def _notes(item: _Loaded, answer: Labelling | Exception) -> tuple[str, ...]:
    """What is doubtful about the recording, what persons said of it, labels that are known, and how it was turned."""
    notes = (*item.recording.notes, *item.said.notes)
    if not isinstance(answer, Labelling):
        return notes
    doubt = item.job.form.doubt_of_up(_labelled_points(answer))
    return (*notes, *answer.stats.get("against", ()), *([doubt] if doubt else []))


def _labelled_points(labelling: Labelling) -> Recording:
    recording = labelling.recording
    labelled = (labelling.identities != NO_MATCH)[..., None]
    return dataclasses.replace(recording, points=np.where(labelled, recording.points, np.nan))


def _keep(item: _Loaded, labelling: Labelling, out: Path, settings: Settings) -> Outcome:
    """Writes the results of one recording."""
    try:
        figures = figures_of(labelling)
        record = {"settings": dataclasses.asdict(settings), "figures": figures, **item.said.record}
        if written := item.job.form.record(item.recording.source):
            record["written"] = written
        write_result(labelling, item.job, out, item.hashes, record)
    except ResultKept as kept:
        return Outcome(item.job, KEPT, str(kept), item.hashes)
    except Exception as error:
        return failed(item.job, error, item.hashes)
    return judged(item.job, settings, item.hashes, figures | {"stats": labelling.stats})
