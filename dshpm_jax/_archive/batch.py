"""Labels a batch of recordings and writes their results; runs in any process that sees the files."""

import dataclasses
import logging
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._archive.hashes import INPUT, MODEL, SETTINGS, hash_file, hash_settings, read_models
from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.outcomes import KEPT, PASSED, Outcome, failed, figures_of, judged
from dshpm_jax._archive.results import ResultKept, write_result
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._labelling import Labelling
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Settings

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Loaded:
    job: Job
    recording: Recording
    model: SubjectModel
    hashes: dict[str, str]


def label_batch(jobs: Sequence[Job], out: Path, settings: Settings) -> list[Outcome]:
    """Labels recordings side by side; one that fails harms no other.

    Nothing but the outcomes stays in memory or goes back to whoever asked.
    """
    start = time.perf_counter()
    models: dict[tuple[Path, ...], tuple[SubjectModel, str]] = {}
    outcomes: list[Outcome] = []
    loaded: list[_Loaded] = []
    for job in jobs:
        try:
            if job.models not in models:
                models[job.models] = read_models(job.models)
            loaded.append(_load(job, *models[job.models], settings))
        except io.NoPoints as error:
            outcomes.append(Outcome(job, PASSED, f"{error} (passed over)"))
        except Exception as error:
            outcomes.append(failed(job, error))
    for item, answer in zip(loaded, _answers(loaded, settings), strict=True):
        if isinstance(answer, Labelling):
            outcome = _keep(item, answer, out, settings)
        else:
            outcome = failed(item.job, answer, item.hashes)
        outcomes.append(dataclasses.replace(outcome, notes=item.recording.notes))
    return _shared(outcomes, time.perf_counter() - start)


def _load(job: Job, model: SubjectModel, model_hash: str, settings: Settings) -> _Loaded:
    # Hashed before it is read: if it changes meanwhile, the hash after labelling is another.
    hashes = {INPUT: hash_file(job.source), SETTINGS: hash_settings(settings), MODEL: model_hash}
    drop = [*io.kept(model.markers), *settings.drop]
    recording = io.read(job.source, settings.unlabelled, drop, settings.frozen_gaps)
    return _Loaded(job, recording, model, hashes)


def _answers(loaded: Sequence[_Loaded], settings: Settings) -> Iterator[Labelling | Exception]:
    """Labels a batch together; where that raises, what is left of it one by one."""
    if not loaded:
        return
    cache_programs()
    from dshpm_jax._label import label_many  # jax is slow to start, and not needed before

    done = 0
    try:
        for answer in label_many([i.recording for i in loaded], [i.model for i in loaded], settings):
            yield answer
            done += 1
    except Exception:
        _log.debug("a batch failed, its recordings go one by one", exc_info=True)
    for item in loaded[done:]:
        try:
            yield next(iter(label_many([item.recording], [item.model], settings)))
        except Exception as error:
            yield error


def _keep(item: _Loaded, labelling: Labelling, out: Path, settings: Settings) -> Outcome:
    """Writes the results of one recording."""
    try:
        figures = figures_of(labelling)
        write_result(
            labelling, item.job, out, item.hashes, {"settings": dataclasses.asdict(settings), "figures": figures}
        )
    except ResultKept as kept:
        return Outcome(item.job, KEPT, str(kept), item.hashes)
    except Exception as error:
        return failed(item.job, error, item.hashes)
    return judged(item.job, settings, item.hashes, figures | {"stats": labelling.stats})


def _shared(outcomes: Sequence[Outcome], seconds: float) -> list[Outcome]:
    """Outcomes with the time of the batch shared out by frames, as its recordings were labelled side by side."""
    frames = sum(outcome.figures.get("frames", 0) for outcome in outcomes)
    return [
        dataclasses.replace(outcome, seconds=round(seconds * outcome.figures["frames"] / frames, 3))
        if outcome.figures
        else outcome
        for outcome in outcomes
    ]
