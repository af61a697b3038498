"""Names for a recording that nobody labelled: of a model, of a known marker set, or typed."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from dshpm_jax import io
from dshpm_jax._archive.hashes import MODEL, read_models
from dshpm_jax._archive.jobs import MODEL_NAME
from dshpm_jax._labelling import Labelling
from dshpm_jax._marker_set import MarkerSet
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import is_unlabelled
from dshpm_jax._review.opening import bare_model, settings_of
from dshpm_jax._review.places import Place
from dshpm_jax._review.solving import solver_for
from dshpm_jax._review.trial import Trial
from dshpm_jax._types import NO_MATCH

MOST_SOURCES = 40
"""count; used in `sources_of`: more models than this are not offered."""

MOST_MARKERS = 256
"""count; used in `add_names`: no model has more."""


@dataclass(frozen=True)
class Source:
    """Where names may come from: a model's file, or a known marker set (then there is none)."""

    id: str
    text: str
    names: tuple[str, ...]
    file: Path | None = None


def sources_of(places: Iterable[Place]) -> list[Source]:
    """The models that trials were labelled with, or that lie beside their recordings, and the known marker sets."""
    from dshpm_jax._model_building.templates import TEMPLATES

    files: dict[Path, None] = {}
    for place in places:
        beside = (place.job.source.parent / MODEL_NAME, place.job.source.parent.parent / MODEL_NAME)
        files |= dict.fromkeys(path.resolve() for path in (*place.job.models, *beside) if path.is_file())
    found = []
    for path in list(files)[:MOST_SOURCES]:
        try:
            names = io.read_model(path).markers
        except ValueError:
            continue
        found.append(Source(f"m{len(found)}", f"{path.parent.name}/{path.name}", names, path))
    for name, parts in TEMPLATES.items():
        if parts:
            names = tuple(dict.fromkeys(marker for part in parts.values() for marker in part))
            found.append(Source(f"t{len(found)}", name, names))
    return found


def take_names(trial: Trial, source: Source) -> None:
    """Gives a trial the names of a source, and its body where it is a model.

    Raises:
        ValueError: labels that the trial has are not among them, or its names are those of its own model.
    """
    _check_free(trial)
    used = _used(trial.session.labelling)
    if lost := [name for name in used if name not in source.names]:
        raise ValueError(f"{lost[0]} is a label here and not among these names; undo it first")
    if source.file is None:
        _give(trial, bare_model((*source.names,)), (), {})
    else:
        model, digest = read_models((source.file,))
        _give(trial, model.model if isinstance(model, MarkerSet) else model, (source.file,), {MODEL: digest})


def add_names(trial: Trial, names: Sequence[Any]) -> None:
    """Adds names to those of a trial; `ValueError` if they are none, or its names are those of its model."""
    _check_free(trial)
    old = trial.session.labelling.model.markers
    new = [name for name in dict.fromkeys(names) if name not in old]
    if wrong := [name for name in new if not isinstance(name, str) or not name.strip() or is_unlabelled(name)]:
        raise ValueError(f"{wrong[0]!r} is no name for a marker")
    if len(old) + len(new) > MOST_MARKERS:
        raise ValueError(f"more than {MOST_MARKERS} names; a model has no more")
    _give(trial, bare_model((*old, *new)), (), {})


def _check_free(trial: Trial) -> None:
    if trial.place.job.models:
        raise ValueError("its names are those of the model that it was labelled with; label it with another model")


def _used(labelling: Labelling) -> list[str]:
    found = np.unique(labelling.identity[labelling.identity != NO_MATCH])
    return [labelling.model.markers[m] for m in found]


def _give(trial: Trial, model: SubjectModel, files: tuple[Path, ...], hashes: Mapping[str, str]) -> None:
    session = trial.session
    labelling, number = session.labelling, {name: k for k, name in enumerate(model.markers)}
    to = [number.get(name, NO_MATCH) for name in labelling.model.markers]
    identity = np.array([NO_MATCH if m == NO_MATCH else to[m] for m in labelling.identity], np.int32)
    none = np.full((len(identity), 2), NO_MATCH, np.int32)
    session.labelling = replace(labelling, model=model, identity=identity, could_be=none)
    session.version += 1
    trial.place = replace(trial.place, job=replace(trial.place.job, models=files))
    trial.head = {**trial.head, "hashes": {**trial.head.get("hashes", {}), **hashes}}
    trial.knows_body = bool(files) and bool(model.neighbourhoods)
    session.solver = solver_for(settings_of(trial.head)) if trial.knows_body else None
    session.kept()
