"""`label` and `label_many`: the one engine behind the command, the notebooks and the tests."""

import warnings
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dshpm_jax._control.methods import Answer, label_control
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._driver import Driver
from dshpm_jax._given import GivenModel, GivenModels, GivenRecording, model_of, one_or_more, recording_of
from dshpm_jax._labelling import Labelling
from dshpm_jax._model import SubjectModel
from dshpm_jax._pretracking import pretrack
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Settings
from dshpm_jax._size import SIZE_REMEDY, size_doubt
from dshpm_jax._trajectories import Trajectories, from_columns


def label(
    recording: GivenRecording,
    model: GivenModels,
    settings: Settings | None = None,
    driver: Driver | None = None,
    tuning: Tuning = TUNING,
) -> Labelling:
    """Labels one recording against the model of its subject, or the models of all its subjects.

    Arguments:
        recording: points in millimetres, or their file, read as `settings` say; names that its columns already carry
            are ignored.
        model: see `SubjectModel.from_recordings`, or its file; for several subjects a model of each, best with their
            names, which go before the markers' names (see `combine_models`).
        settings: the method and its parameters.
        driver: holds the scores (`Driver(candidate_score=..., match_score=...)`).
        tuning: the numbers of the full method, for who develops it.

    Raises:
        ReadError: a file cannot be read.
        ValueError: the recording has no points.

    Warns:
        UserWarning: the points are spread over a few millimetres or kilometres, or are not of the model's size.
    """
    known = model_of(model)
    recording = recording_of(recording, known, settings)
    rescaled = settings is not None and settings.rescale
    if not rescaled and (doubt := size_doubt(recording, known)):
        who = recording.source.name if recording.source else "the recording"
        warnings.warn(f"{who}: {doubt}; {SIZE_REMEDY}", stacklevel=2)
    return next(label_many([recording], known, settings, driver, tuning))


def label_many(
    recordings: Iterable[GivenRecording],
    models: GivenModel | Sequence[GivenModel],
    settings: Settings | None = None,
    driver: Driver | None = None,
    tuning: Tuning = TUNING,
) -> Iterator[Labelling]:
    """Labels recordings side by side, so that their kernels share batches; the labels are those of `label`.

    Nothing is warned of: who labels many looks at what came out.

    Arguments:
        recordings: points in millimetres, or their files; all are in memory together.
        models: one for all, or one for each recording; `combine_models` makes one of several subjects.
        settings, driver, tuning: as for `label`.

    Yields:
        a `Labelling` for each recording, in order; with `Settings.rescale` its model is the rescaled one.
    """
    settings = Settings() if settings is None else settings
    driver = Driver() if driver is None else driver
    given = one_or_more(recordings)
    models = _one_for_each(models, len(given))
    recordings = [recording_of(one, model, settings) for one, model in zip(given, models)]
    tracked = [_trajectories(recording, settings) for recording in recordings]
    controls = (label_control(t, model, settings, tuning) for t, model in zip(tracked, models))
    for recording, answer in zip(recordings, driver.run(controls)):
        yield _labelling(recording, answer)


def _one_for_each(models: GivenModel | Sequence[GivenModel], count: int) -> list[SubjectModel]:
    """A model for each of so many recordings; a file is read once, however often it is given."""
    if isinstance(models, GivenModel):
        return [model_of(models)] * count
    if len(models) != count:
        raise ValueError(f"{count} recordings but {len(models)} models; give one for all or one for each")
    read = {model: model_of(model) for model in models if isinstance(model, str | Path)}
    return [model if isinstance(model, SubjectModel) else read[model] for model in models]


def _labelling(recording: Recording, answer: Answer) -> Labelling:
    stats: dict[str, Any] = {"svd_count": answer.fits}
    if answer.model_fit is not None:
        stats["model_fit"] = answer.model_fit
    return Labelling(
        recording,
        answer.model,
        answer.trajectories,
        answer.identity,
        answer.confidence,
        answer.reason,
        stats,
        answer.could_be,
    )


def _trajectories(recording: Recording, settings: Settings) -> Trajectories:
    points = recording.points
    if settings.method == "static":
        found = from_columns(points, recording.rate, np.full(points.shape[:2], -1))
    else:
        found = pretrack(recording)
    if not len(found):
        raise ValueError("no point is seen in any frame; there is nothing to label")
    return found
