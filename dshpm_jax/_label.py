"""`label` and `label_many`: the one engine behind the command, the notebooks and the tests."""

import warnings
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.fixed_labels import FixedLabels, fix
from dshpm_jax._control.methods import Answer, label_control
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._driver import Driver
from dshpm_jax._given import (
    GivenModelOrSet,
    GivenModels,
    GivenRecording,
    model_or_set_of,
    one_or_more,
    recording_of,
)
from dshpm_jax._known import KnownLabel, known_points, names_known, without
from dshpm_jax._labelling import Labelling
from dshpm_jax._marker_set import MarkerSet, Member
from dshpm_jax._model import SubjectModel
from dshpm_jax._pretracking import pretrack
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Settings
from dshpm_jax._size import SIZE_REMEDY, size_doubt
from dshpm_jax._trajectories import Trajectories, from_columns
from dshpm_jax.io import first_frame


def label(
    recording: GivenRecording,
    model: GivenModels | MarkerSet | Member,
    settings: Settings | None = None,
    driver: Driver | None = None,
    tuning: Tuning = TUNING,
    known: Sequence[KnownLabel] = (),
) -> Labelling:
    """Labels one recording against the model of its subject, or the models of all its subjects.

    Arguments:
        recording: points in millimetres, or their file, read as `settings` say; names that its columns already carry
            are ignored unless `Settings.keep_labels`.
        model: see `SubjectModel.from_recordings`, or its file; for several subjects a model of each, best with their
            names, which go before the markers' names (see `combine_models`). Or a `MarkerSet`, or its file, for a
            subject of whom nothing is labelled; the model of the answer is then the subject's own. A `Member` of a set
            is a subject whose model was found before (`find_subject`).
        settings: the method and its parameters.
        driver: holds the scores (`Driver(candidate_score=..., match_score=...)`).
        tuning: the numbers of the full method, for who develops it.
        known: labels that are given; nothing overrules them, and everything else is labelled around them. Where the
            evidence is against one, `Labelling.stats["against"]` says so.

    Raises:
        ReadError: a file cannot be read.
        ValueError: the recording has no points, or known labels contradict each other or are of other markers.

    Warns:
        UserWarning: the points are spread over a few millimetres or kilometres, or are not of the model's size.
    """
    subject = model_or_set_of(model)
    recording = recording_of(recording, subject, settings)
    rescaled = settings is not None and settings.rescale
    typical = subject if isinstance(subject, SubjectModel) else subject.model
    if not rescaled and (doubt := size_doubt(recording, typical)):
        who = recording.source.name if recording.source else "the recording"
        warnings.warn(f"{who}: {doubt}; {SIZE_REMEDY}", stacklevel=2)
    return next(label_many([recording], subject, settings, driver, tuning, [known]))


def label_many(
    recordings: Iterable[GivenRecording],
    models: GivenModelOrSet | Sequence[GivenModelOrSet],
    settings: Settings | None = None,
    driver: Driver | None = None,
    tuning: Tuning = TUNING,
    known: Sequence[Sequence[KnownLabel]] | None = None,
) -> Iterator[Labelling]:
    """Labels recordings side by side, so that their kernels share batches; the labels are those of `label`.

    Nothing is warned of: who labels many looks at what came out.

    Arguments:
        recordings: points in millimetres, or their files; all are in memory together.
        models: one for all, or one for each recording; `combine_models` makes one of several subjects. With a
            `MarkerSet` each recording is taken for one of a subject of its own.
        settings, driver, tuning: as for `label`.
        known: for each recording the labels that are given, as for `label`.

    Yields:
        a `Labelling` for each recording, in order; with `Settings.rescale` its model is the rescaled one.
    """
    settings = Settings() if settings is None else settings
    driver = Driver() if driver is None else driver
    given = one_or_more(recordings)
    models = _one_for_each(models, len(given))
    recordings = [recording_of(one, model, settings) for one, model in zip(given, models)]
    known = known or [()] * len(given)
    tracked = [_tracked(*one, settings) for one in zip(recordings, models, known, strict=True)]
    controls = (label_control(t, model, settings, tuning, fixed) for (t, fixed), model in zip(tracked, models))
    for recording, answer in zip(recordings, driver.run(controls)):
        yield labelling_of(recording, answer)


def _one_for_each(
    models: GivenModelOrSet | Sequence[GivenModelOrSet], count: int
) -> list[SubjectModel | MarkerSet | Member]:
    """A model for each of so many recordings; a file is read once, however often it is given."""
    if isinstance(models, GivenModelOrSet):
        return [model_or_set_of(models)] * count
    if len(models) != count:
        raise ValueError(f"{count} recordings but {len(models)} models; give one for all or one for each")
    read = {model: model_or_set_of(model) for model in models if isinstance(model, str | Path)}
    return [read[model] if isinstance(model, str | Path) else model for model in models]


def labelling_of(recording: Recording, answer: Answer) -> Labelling:
    """What a control says of the trajectories of a recording, as it is given out."""
    stats: dict[str, Any] = {"svd_count": answer.fits}
    if answer.against.any():
        stats["against"] = [_told(recording, answer, int(j)) for j in np.flatnonzero(answer.against)]
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


def _told(recording: Recording, answer: Answer, trajectory: int) -> str:
    """A known label that the evidence is against, in words."""
    t = answer.trajectories
    start, stop = int(t.start[trajectory]), int(t.stop[trajectory])
    column = recording.columns[t.column[start, t.slot[trajectory]]]
    label = answer.model.markers[answer.identity[trajectory]]
    return f"{KnownLabel(column, start, stop, label)}, which is known, but the points do not lie like it"


def _tracked(
    recording: Recording, model: SubjectModel | MarkerSet | Member, known: Sequence[KnownLabel], settings: Settings
) -> tuple[Trajectories, FixedLabels]:
    """The trajectories of a recording, cut where a known label ends, and the labels that are known of them."""
    points = points_given(recording, model, known, settings)
    tracks, identity, _ = fix(_trajectories(recording, settings), points)
    return tracks, FixedLabels.of(tracks, identity, len(model.markers))


def points_given(
    recording: Recording, model: SubjectModel | MarkerSet | Member, known: Sequence[KnownLabel], settings: Settings
) -> Int[np.ndarray, "frames points"]:
    """What is known of each point, see `known_points`: by `known`, and else by its column's name where that counts."""
    names = _names(recording, model, settings)
    for one in known:
        names = without(names, one)
    return known_points(recording, model.markers, [*names, *known])


def _names(recording: Recording, model: SubjectModel | MarkerSet | Member, settings: Settings) -> Sequence[KnownLabel]:
    """What the names of the recording's columns say, where they count."""
    if not settings.keep_labels:
        return ()
    if settings.keep_frames is None:
        return names_known(recording, model.markers)
    offset = first_frame(recording.source) if recording.source else 0
    first, last = settings.keep_frames[0] - offset, settings.keep_frames[1] - offset + 1
    first, last = max(first, 0), min(last, recording.num_frames)
    return names_known(recording, model.markers, first, last) if first < last else ()


def _trajectories(recording: Recording, settings: Settings) -> Trajectories:
    points = recording.points
    if settings.method == "static":
        found = from_columns(points, recording.rate, np.full(points.shape[:2], -1))
    else:
        found = pretrack(recording)
    if not len(found):
        raise ValueError("no point is seen in any frame; there is nothing to label")
    return found
