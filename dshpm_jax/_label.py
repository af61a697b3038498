"""`label` and `label_many`: the one engine behind the command, the notebooks and the tests."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from dshpm_jax._control.methods import Answer, label_control
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._driver import Driver
from dshpm_jax._labelling import Labelling
from dshpm_jax._model import SubjectModel
from dshpm_jax._pretracking import pretrack
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Settings
from dshpm_jax._subjects import combine_models
from dshpm_jax._trajectories import Trajectories, from_columns


def label(
    recording: Recording,
    model: SubjectModel | Sequence[SubjectModel] | Mapping[str, SubjectModel],
    settings: Settings | None = None,
    driver: Driver | None = None,
    tuning: Tuning = TUNING,
) -> Labelling:
    """Labels one recording against the model of its subject, or the models of all its subjects.

    Arguments:
        recording: points in millimetres; names that its columns already carry are ignored.
        model: see `SubjectModel.from_recordings`; for several subjects a model of each, best with their names, which
            go before the markers' names (see `combine_models`).
        settings: the method and its parameters.
        driver: holds the scores (`Driver(candidate_score=..., match_score=...)`).
        tuning: the numbers of the full method, for who develops it.

    Raises:
        ValueError: the recording has no points.
    """
    model = model if isinstance(model, SubjectModel) else combine_models(model)
    return next(label_many([recording], model, settings, driver, tuning))


def label_many(
    recordings: Iterable[Recording],
    models: SubjectModel | Sequence[SubjectModel],
    settings: Settings | None = None,
    driver: Driver | None = None,
    tuning: Tuning = TUNING,
) -> Iterator[Labelling]:
    """Labels recordings side by side, so that their kernels share batches; the labels are those of `label`.

    Arguments:
        models: one for all, or one for each recording; `combine_models` makes one of several subjects.
        settings, driver, tuning: as for `label`.

    Yields:
        a `Labelling` for each recording, in order; with `Settings.rescale` its model is the rescaled one.
    """
    settings = Settings() if settings is None else settings
    driver = Driver() if driver is None else driver
    recordings = list(recordings)
    if isinstance(models, SubjectModel):
        models = [models] * len(recordings)
    if len(models) != len(recordings):
        raise ValueError(f"{len(recordings)} recordings but {len(models)} models; give one for all or one for each")
    tracked = [_trajectories(recording, settings) for recording in recordings]
    controls = (label_control(t, model, settings, tuning) for t, model in zip(tracked, models))
    for recording, answer in zip(recordings, driver.run(controls)):
        yield _labelling(recording, answer)


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
