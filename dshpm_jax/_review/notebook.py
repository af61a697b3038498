"""`review`: the page over one labelling, inside a notebook, and what was corrected as an object."""

import html
from collections.abc import Sequence
from pathlib import Path

from dshpm_jax._archive.jobs import Job
from dshpm_jax._corrections import Correction
from dshpm_jax._given import GivenModel, GivenRecording, model_of, recording_of
from dshpm_jax._known import KnownLabel
from dshpm_jax._labelling import Labelling
from dshpm_jax._review.desk import Desk
from dshpm_jax._review.opening import bare_model
from dshpm_jax._review.places import Place
from dshpm_jax._review.serving import Server
from dshpm_jax._review.session import Session
from dshpm_jax._review.solving import solver_for
from dshpm_jax._review.trial import Trial, unlabelled
from dshpm_jax._settings import Settings

HEIGHT = 760  # of the page in a notebook (pixels)

NOTEBOOKS = ("http://localhost:*", "http://127.0.0.1:*")
"""Origins whose pages may show the page inside theirs: notebooks that this machine serves."""


class _Memory:
    """The log of a session that no file is kept of: the session itself has the lines."""

    def append(self, correction: Correction) -> None:
        pass


class Review:
    """A labelling under correction. In a notebook it shows the page; elsewhere `address` opens it in a browser.

    Attributes:
        address: of the page, on this machine alone, until `close` or the end of the process.
    """

    def __init__(self, labelling: Labelling, settings: Settings, name: str):
        self._session = Session(labelling, _Memory())
        knows_body = bool(labelling.model.neighbourhoods)
        self._session.solver = solver_for(settings) if knows_body else None
        place = Place("0" * 16, name, Path(), Job(Path(name), Path(f"{name}.c3d")), {})
        self._server = Server(Desk({place.id: place}, name, Trial(place, self._session, {}, knows_body)), 0, NOTEBOOKS)
        self._server.start()
        self.address = self._server.address

    @property
    def corrections(self) -> tuple[KnownLabel, ...]:
        """What was said so far; `label(recording, model, known=...)` takes it."""
        with self._session.lock:
            return self._session.known()

    @property
    def labelling(self) -> Labelling:
        """The labels as they are corrected so far; the labelling that was given stays as it is."""
        with self._session.lock:
            return self._session.labelling

    def close(self) -> None:
        """Ends the page; corrections stay."""
        self._server.stop()

    def _repr_html_(self) -> str:
        style = "width: 100%; border: 0; border-radius: 8px"
        return f'<iframe src="{html.escape(self.address)}" height="{HEIGHT}" style="{style}"></iframe>'

    def __repr__(self) -> str:
        return f"Review at {self.address} with {len(self.corrections)} corrections"


def review(
    what: Labelling | GivenRecording,
    model: GivenModel | None = None,
    names: Sequence[str] = (),
    settings: Settings | None = None,
    name: str | None = None,
) -> Review:
    """The page in which a person sets the last labels, over one labelling, and what is corrected there.

    Nothing is written to files: `Review.labelling` has the corrected labels, `Review.corrections` what was said.

    Arguments:
        what: a labelling of the full method, so that what follows from a correction can be solved; or a recording that
            nobody labelled, or its file, to be named from nothing.
        model: of the subject of a recording, if there is one; gives the names and solves what follows.
        names: for a recording without a model, the names to give, besides those of its columns.
        settings: those that the labelling was made with; by default the usual ones.
        name: the title; by default the name of the recording's file.

    Raises:
        ImportError: the extra `review` is not installed.
        ReadError: a file cannot be read.
        ValueError: there are no points, or a labelling came with a model or names of its own.
    """
    settings = Settings() if settings is None else settings
    if not isinstance(what, Labelling):
        what = _named(what, model, names, settings)
    elif model is not None or names:
        raise ValueError("a labelling has its own model and names; give neither")
    source = what.recording.source
    return Review(what, settings, name or (source.name if source else "recording"))


def _named(given: GivenRecording, model: GivenModel | None, names: Sequence[str], settings: Settings) -> Labelling:
    body = None if model is None else model_of(model)
    recording = recording_of(given, body, settings)
    if body is None:
        own = (label for label, named in zip(recording.labels, recording.labelled, strict=True) if named)
        body = bare_model(tuple(dict.fromkeys([*own, *names])))
    return unlabelled(recording, body)
