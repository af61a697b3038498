"""`view`: a labelled recording as one page in which it plays."""

import html
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dshpm_jax._given import GivenModels, model_of
from dshpm_jax._labelling import Labelling
from dshpm_jax._model_building import named_frame, one_frame, segment_entries
from dshpm_jax._recording import Recording
from dshpm_jax.io import read, read_sidecar, sidecar, sidecar_path
from dshpm_jax.report._film import make_film, parts_of_model
from dshpm_jax.report._page import make_page, write_page
from dshpm_jax.report._player import player_data

HEIGHT = 680  # of the page in a notebook (pixels)


@dataclass(frozen=True)
class Page:
    """A self-contained page. In a notebook it shows itself.

    Attributes:
        html: all of it; it loads nothing from anywhere.
    """

    html: str

    def save(self, path: str | Path) -> None:
        """Writes the page; an earlier page there gives way, any other file does not (`WriteError`)."""
        write_page(self.html, Path(path))

    def _repr_html_(self) -> str:
        style = "width: 100%; border: 0; border-radius: 8px"
        return f'<iframe srcdoc="{html.escape(self.html)}" height="{HEIGHT}" style="{style}"></iframe>'

    def __repr__(self) -> str:
        return f"Page of {len(self.html) / 1e6:.1f} MB; .save(path) writes it"


def view(what: Labelling | Recording | str | Path, model: GivenModels | None = None, name: str | None = None) -> Page:
    """A page in which a labelled recording plays, with a timeline of its labels, their gaps and confidences.

    Arguments:
        what: a labelling, a recording with labels, or the file of one; if the sidecar that `label` wrote is beside the
            file, it gives segments and confidences.
        model: gives the segments where they are not known; or its file, or the models of several subjects (see
            `combine_models`). Without it, markers are linked by distance alone.
        name: the title; by default the name of the file.

    Raises:
        ReadError: the file cannot be read, or the sidecar beside it is about another recording.
        ValueError: no point is seen in any frame.
    """
    recording, sidecar = _with_sidecar(what)
    known = None if model is None else model_of(model)
    parts = parts_of_model(known.segments, known.markers) if known is not None else None
    source = what.recording.source if isinstance(what, Labelling) else recording.source
    title = name or (source.name if source else "recording")
    return Page(make_page("player", title, player_data(make_film(recording, sidecar, parts), title)))


def write_trial_page(labelling: Labelling, record: Mapping[str, Any], path: Path, name: str) -> None:
    """Writes the page that `view` makes of a result, from what was written into it; raises `WriteError`.

    Arguments:
        record: what its sidecar holds besides `labelling`.
        name: the title, as `view` has it that of the result's file.
    """
    film = make_film(labelling.to_recording(), sidecar(labelling) | dict(record))
    write_page(make_page("player", name, player_data(film, name)), path)


def view_frame(
    recording: Recording,
    frame: int = 0,
    names: Mapping[int, str] | None = None,
    segments: Mapping[str, Any] | None = None,
    name: str | None = None,
) -> Page:
    """A page of one frame in which to find out which point is which marker: every point with its number.

    A click on a point leads to a field for its name and segments; the page turns what is typed there into the `names`
    and `segments` that `SubjectModel.from_frame` takes (section 5.1.1). `review(recording, names=...)` names markers by
    clicking, and gives the labels themselves.

    Arguments:
        recording: its columns need no names.
        frame: which frame, from 0.
        names: what is named already: the number of a point (its column) to its marker.
        segments: what is grouped already; see `SubjectModel.from_recordings`.
        name: the title.

    Raises:
        ValueError: no point is seen in the frame, or a name or a number is wrong.
    """
    names = dict(names or {})
    if names:
        named_frame(recording, frame, names)  # raises where they are wrong
    still = one_frame(recording, frame)
    numbers = np.flatnonzero(still.present[0]).tolist()
    labels = tuple(names.get(k, str(k)) for k in numbers)
    shown = Recording(still.points[:, numbers], labels, recording.rate)
    parts = {part: list(entry["markers"]) for part, entry in segment_entries(segments).items()} if segments else {}
    title = name or f"frame {frame}"
    data = player_data(make_film(shown, parts=parts), title) | {"numbers": numbers, "named": names}
    return Page(make_page("player", title, data, "naming"))


def _with_sidecar(what: Labelling | Recording | str | Path) -> tuple[Recording, dict[str, Any] | None]:
    if isinstance(what, Labelling):
        return what.to_recording(), sidecar(what)
    if isinstance(what, Recording):
        return what, None
    return read(what), read_sidecar(sidecar_path(what))
