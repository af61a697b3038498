"""The queue: trials and their doubts by what is at stake, points that are likely wrong."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from dshpm_jax import io
from dshpm_jax._corrections import CorrectionsError, read_corrections
from dshpm_jax._review.places import Place
from dshpm_jax._review.shown import stake_of
from dshpm_jax.report._doubts import doubt_of
from dshpm_jax.report._run_rows import severity

MAX_DOUBTS = 40  # of a trial that are listed


def queue(places: Iterable[Place]) -> list[dict[str, Any]]:
    """A row for each trial, the one with the most points at stake first; those without a result come last."""
    rows = [_row(place) for place in places]
    return sorted(rows, key=lambda row: (not row["opens"], -row["stake"], row["severity"], row["name"]))


def _row(place: Place) -> dict[str, Any]:
    sidecar = io.read_sidecar(place.sidecar, column_runs=False)
    row = {"id": place.id, "name": place.name, "outcome": place.row.get("outcome"), "severity": severity(place.row)}
    if sidecar is None:
        why, new = place.row.get("message"), not place.row
        return {**row, "stake": 0, "doubts": [], "count": 0, "opens": new, "why": why or "not labelled yet", "new": new}
    confirmed = _confirmed(place)
    doubts = [] if confirmed else doubts_in(sidecar)
    stake = sum(doubt["stake"] for doubt in doubts)
    opens = {"opens": True, "stake": round(stake, 3), "count": len(doubts), "doubts": doubts[:MAX_DOUBTS]}
    return {**row, **opens, "confirmed": confirmed}


def _confirmed(place: Place) -> bool:
    try:
        found = read_corrections(place.corrections)
    except CorrectionsError:  # which opening the trial says
        return False
    return found is not None and found.confirmed


def in_hand(place: Place, tracks: Sequence[Sequence[Any]]) -> dict[str, Any]:
    """The row of a trial that is in no file, by its tracks as the page has them."""
    stakes = [track[6] for track in tracks if track[6]]
    row = {"id": place.id, "name": place.name, "outcome": None, "severity": 0, "opens": True}
    return {**row, "stake": round(sum(stakes), 3), "count": len(stakes), "doubts": []}


def doubts_in(sidecar: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The doubts of a trial, those with the most points at stake first."""
    found = []
    for track in sidecar["trajectories"]:
        if doubt := doubt_of(track, sidecar):
            stake = round(stake_of(doubt) / sidecar["rate"], 3)
            label = doubt.label or next(iter(doubt.could_be), None)
            place = {"first": doubt.frames[0], "last": doubt.frames[1]}
            found.append({"label": label, "given": doubt.label is not None, **place, "stake": stake})
    return sorted(found, key=lambda one: (-one["stake"], one["first"]))
