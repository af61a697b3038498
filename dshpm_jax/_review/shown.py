"""A trial as its page shows it: points once, labels whenever they change."""

import shlex
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Int

from dshpm_jax._archive.manifest import known_rows
from dshpm_jax._hierarchy import depth_first
from dshpm_jax._known import KnownLabel
from dshpm_jax._labelling import WITHHELD, Labelling
from dshpm_jax._review.places import Place
from dshpm_jax._review.saying import history, words
from dshpm_jax._review.session import Session
from dshpm_jax._review.trial import Trial
from dshpm_jax._trajectories import Trajectories, by_marker
from dshpm_jax._types import NO_MATCH
from dshpm_jax.report._doubts import SURE, LabelDoubt, doubt_of, troubles_of
from dshpm_jax.report._links import Part, links_of
from dshpm_jax.report._player import parts_data, room_data

LASTING = 0.5
"""share; used in `_lasting`: of the longest trajectory's life; false points live shorter."""


def room_of(trial: Trial) -> tuple[dict[str, Any], Int[np.ndarray, "frames slots+1 3"]]:
    """What stays the same however labels change, and the points, packed as trajectories are."""
    labelling = trial.session.labelling
    markers, tracks = _by_marker(labelling), labelling.trajectories
    figure = markers if np.isfinite(markers).any() else _lasting(tracks)
    names = labelling.model.markers
    room, steps = room_data(tracks.points, figure, names if figure is markers else (), labelling.recording.rate)
    own = {
        "id": trial.place.id,
        "name": trial.place.name,
        "slots": tracks.points.shape[1],
        "solves": trial.session.solver is not None,
        "knows_body": trial.knows_body,
        "learning": learning(trial.place),
        "troubles": troubles_of({**trial.head, "trajectories": [{"label": ""}]}) if trial.head else [],
    }
    return {**room, **own}, steps


def learning(place: Place) -> list[str]:
    """The commands that make the model of a trial's subject again and label the rest; none where that cannot be."""
    subjects = {tuple(row["models"]) for row in known_rows(place.out).values() if row.get("output")}
    if len(place.job.models) != 1 or len(subjects) != 1:
        return []
    new = place.job.models[0].with_name(f"{place.job.models[0].stem}-again.json")
    out, source = str(place.out), str(place.job.source.parent)
    make_it = ["dshpm-jax", "model", "--from", out, "-o", str(new)]
    label_it = ["dshpm-jax", "label", source, "--model", str(new), "-o", out]
    return [shlex.join(make_it), shlex.join(label_it)]


def body_of(labelling: Labelling) -> dict[str, Any]:
    """Names, segments and sticks, which change where names are given anew."""
    model = labelling.model
    parts = [Part(model.segments[s].name, model.segments[s].markers) for s in depth_first(model.segments)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of markers that nobody has labelled yet
        links = links_of(_by_marker(labelling), parts, model.markers)
    return {"names": model.markers, **parts_data(parts, links)}


def state_of(session: Session, head: Mapping[str, Any]) -> dict[str, Any]:
    """Everything that corrections change."""
    standing, undone = session.standing, session.undone
    return {
        "version": session.version,
        **tracks_of(session.labelling, session.known(), head, session.confirmed),
        "confirmed": session.confirmed,
        "undo": words(standing[-1]) if standing else None,
        "redo": words(undone[-1]) if undone else None,
        "history": history(standing, undone),
    }


def tracks_of(
    labelling: Labelling, known: Sequence[KnownLabel], head: Mapping[str, Any], confirmed: bool = False
) -> dict[str, Any]:
    """A row for each trajectory, see TRACK in `page/recording.js`, and what their reasons are.

    Arguments:
        known: what persons have said.
        head: of the sidecar.
        confirmed: whether a person has said that all is right; nothing is in doubt then.
    """
    tracks, said = labelling.trajectories, known_tracks(labelling, known)
    context = {**head, "rate": labelling.recording.rate}
    reasons: dict[str, int] = {}
    rows = []
    for j in range(len(tracks)):
        clear = said[j] or confirmed or not _may_be_doubtful(labelling, j)
        doubt = None if clear else doubt_of(_row(labelling, j), context)
        reason = doubt.words if doubt else "set by you" if said[j] else str(labelling.reason[j])
        place = [int(tracks.slot[j]), int(tracks.start[j]), int(tracks.stop[j]) - 1]
        number = reasons.setdefault(reason, len(reasons))
        sure = round(float(labelling.confidence[j]), 3)
        stake = round(stake_of(doubt) / labelling.recording.rate, 3) if doubt else 0
        rows.append([*place, int(labelling.identity[j]), sure, number, stake, int(said[j])])
    return {"tracks": rows, "reasons": list(reasons)}


def _may_be_doubtful(labelling: Labelling, j: int) -> bool:
    """Whether it is worth a look; most trajectories are not."""
    named = labelling.identity[j] != NO_MATCH
    return labelling.confidence[j] < SURE if named else labelling.reason[j] in WITHHELD


def stake_of(doubt: LabelDoubt) -> float:
    """Points that are likely wrong: of a label given, or missing, where a right one is withheld."""
    return doubt.points * (1 - doubt.chance if doubt.label is not None else doubt.chance)


def known_tracks(labelling: Labelling, known: Sequence[KnownLabel]) -> Bool[np.ndarray, " trajectories"]:
    """Of which trajectories a person has said what they are, from end to end."""
    tracks, columns = labelling.trajectories, labelling.recording.columns
    count = np.zeros(len(tracks), int)
    for one in known:
        if one.column not in columns:
            continue
        cells = tracks.column[one.first : one.last] == columns.index(one.column)
        count += np.bincount(tracks.index[one.first : one.last][cells], minlength=len(tracks))
    return count >= tracks.stop - tracks.start


def _row(labelling: Labelling, j: int) -> dict[str, Any]:
    """As a sidecar has it."""
    tracks, markers = labelling.trajectories, labelling.model.markers
    others = () if labelling.could_be is None else labelling.could_be[j]
    identity = labelling.identity[j]
    return {
        "frames": [int(tracks.start[j]), int(tracks.stop[j]) - 1],
        "label": None if identity == NO_MATCH else markers[identity],
        "confidence": float(labelling.confidence[j]),
        "reason": str(labelling.reason[j]),
        "could_be": [markers[m] for m in others if m != NO_MATCH],
    }


def _lasting(tracks: Trajectories) -> np.ndarray:
    """The points of long trajectories, which are rarely false, so that they show how large the body is."""
    lives = tracks.stop - tracks.start
    lasting = np.append(lives >= LASTING * lives.max(), False)
    return np.where(lasting[tracks.index][..., None], tracks.points, np.nan)


def _by_marker(labelling: Labelling) -> np.ndarray:
    return by_marker(labelling.recording.points, labelling.identities, labelling.model.num_markers)
