"""A trial of a folder, opened to be corrected: read, brought up to date with its corrections, and locked."""

import os
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from dshpm_jax import io
from dshpm_jax._archive.hashes import INPUT, MODEL, hash_file, read_models
from dshpm_jax._archive.own_models import own_model_of
from dshpm_jax._archive.said import APPLIED
from dshpm_jax._corrections import Correction, Locked, append, check_belongs, locked, read_corrections
from dshpm_jax._given import recording_of
from dshpm_jax._labelling import Labelling, Reason
from dshpm_jax._marker_set import MarkerSet
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._review.opening import bare_model, labelling_of, segments_of, settings_of
from dshpm_jax._review.places import Place
from dshpm_jax._review.saying import cuts_of
from dshpm_jax._review.session import Session
from dshpm_jax._review.solving import solver_for
from dshpm_jax._types import NO_MATCH


class CannotOpen(ValueError):
    """A trial that cannot be corrected; one line says why, and what to do."""


@dataclass(frozen=True)
class _File:
    """The log of a session: the file of corrections beside a result."""

    path: Path
    recording: Path

    def append(self, correction: Correction) -> None:
        append(self.path, correction, self.recording)


@dataclass(eq=False)
class Trial:
    """A trial in hand, and what it was opened from.

    Attributes:
        head: what its sidecar says besides the trajectories; empty if it was never labelled.
        knows_body: whether its model knows distances, and not names alone.
        written: the version of the session that its result has.
    """

    place: Place
    session: Session
    head: Mapping[str, Any]
    knows_body: bool
    written: int = 0
    _held: ExitStack = field(default_factory=ExitStack)

    def close(self) -> None:
        """Lets others correct it."""
        with suppress(OSError):  # some systems keep files that are open; the file is harmless there
            self.place.lock.unlink()
        self._held.close()


def open_trial(place: Place) -> Trial:
    """Opens a result to be corrected, and keeps others from doing so until it is closed.

    Raises:
        CannotOpen: its recording is not there or has changed, somebody else corrects it, or a file is damaged.
    """
    with ExitStack() as stack:
        try:
            place.lock.parent.mkdir(parents=True, exist_ok=True)
            lock = stack.enter_context(locked(place.lock))
            if not _is_still(place.lock, lock):
                raise Locked(f"{place.lock}: was just let go")
            session, head, knows_body = _read(place)
        except Locked:
            raise CannotOpen(f"{place.name}: somebody else is correcting it; close the other page first") from None
        except (ValueError, OSError) as error:
            text = f"{place.name}: {error.strerror}; check the disk" if isinstance(error, OSError) else str(error)
            raise CannotOpen(text) from None
        return Trial(place, session, head, knows_body, _held=stack.pop_all())


def _is_still(path: Path, file: BinaryIO) -> bool:
    """Whether a file that was locked still has its name: whoever held it before removes it."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), os.stat(path))
    except FileNotFoundError:
        return False


def _read(place: Place) -> tuple[Session, Mapping[str, Any], bool]:
    source = place.job.source
    if not source.is_file():
        raise CannotOpen(f"{source}: the recording is not there any more; put it back, or label it from where it is")
    sidecar = io.read_sidecar(place.sidecar)
    if sidecar is None and place.sidecar.exists():
        raise CannotOpen(f"{place.sidecar}: is damaged; label the recording again")
    if sidecar is None:
        return Session(unlabelled(io.read(source)), _File(place.corrections, source)), {}, False
    if hash_file(source) != sidecar.get("hashes", {}).get(INPUT):
        raise CannotOpen(f"{source}: has changed since it was labelled; label it again")
    model, knows_body = _model(place, sidecar)
    settings = settings_of(sidecar)
    recording = recording_of(source, model, settings)
    found = read_corrections(place.corrections)
    if found is not None:
        check_belongs(found, place.corrections, source)
    lines = list(found.lines if found is not None else ())
    labelling = labelling_of(sidecar, recording, model, [cut for line in lines for cut in cuts_of(line)])
    session = Session(labelling, _File(place.corrections, source), lines)
    session.catch_up(sidecar.get(APPLIED, ()))
    session.solver = solver_for(settings) if knows_body else None
    head = {name: value for name, value in sidecar.items() if name != "trajectories"}
    return session, head, knows_body and not settings.rescale


def unlabelled(recording: Recording, model: SubjectModel | None = None) -> Labelling:
    """A recording that nobody labelled: what its columns are called is known.

    Arguments:
        model: gives the names that there are; without one these are the names of the columns alone.
    """
    from dshpm_jax._pretracking import pretrack  # imports jax

    tracks = pretrack(recording)
    own = tuple(dict.fromkeys(name for name, named in zip(recording.labels, recording.labelled) if named))
    model = bare_model(own) if model is None else model
    number = {name: k for k, name in enumerate(model.markers)}
    column = tracks.column[tracks.start, tracks.slot]
    identity = np.array([number.get(recording.labels[c], NO_MATCH) for c in column], np.int32)
    named = identity != NO_MATCH
    reason = tuple(Reason.KNOWN if known else Reason.OUTSIDE for known in named)
    return Labelling(recording, model, tracks, identity, named.astype(float), reason)


def _model(place: Place, sidecar: Mapping[str, Any]) -> tuple[SubjectModel, bool]:
    """The model that the result was made with, if it is there as it was; else its names."""
    markers = tuple(sidecar["markers"])
    try:
        model, digest = read_models(place.job.models)
        if isinstance(model, MarkerSet):
            model = own_model_of(place.job, digest, place.out) or model.model
        if digest == sidecar.get("hashes", {}).get(MODEL) and model.markers == markers:
            return model, bool(model.neighbourhoods)
    except (ValueError, OSError, IndexError):
        pass
    return bare_model(markers, segments_of(sidecar)), False
