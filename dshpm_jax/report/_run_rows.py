"""Trials and doubts as the page of a run takes them, in few bytes."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from dshpm_jax._labelling import Reason
from dshpm_jax._outcomes import WORST_FIRST
from dshpm_jax.report._doubts import CAUSES, LabelDoubt
from dshpm_jax.report._page import is_page
from dshpm_jax.report._page_name import page_of_result

MAX_DOUBTS = 40  # of a trial that are listed, the longest; the page says how many there are
MAX_TEXT = 400  # characters of a message
USUAL_PAGE = 1  # beside the result and named like it


def severity(row: Mapping[str, Any]) -> int:
    """Where a trial comes by its outcome; one that nobody knows comes first."""
    outcome = row.get("outcome")
    return WORST_FIRST.index(outcome) if outcome in WORST_FIRST else -1


def trial_row(
    name: str,
    row: Mapping[str, Any],
    doubt: tuple[float, int, float | None],
    out: Path,
    tracks: Sequence[Mapping[str, Any]] = (),
    confirmed: bool = False,
) -> list[Any]:
    """A trial as a list, see FIELDS in `run/trials.js`.

    Arguments:
        row: its row of the manifest.
        doubt: seconds in doubt, the number of its doubts, and the mean confidence of its labels.
        out: the folder of the results.
        tracks: the trajectories of its sidecar.
        confirmed: whether a person has confirmed it.
    """
    stake, doubts, sure = doubt
    counts = [row.get(key) for key in ("completeness", "frames", "labelled_trajectories", "trajectories", "seconds")]
    short = [round(count, 4) if isinstance(count, float) else count for count in counts]
    more: dict[str, Any] = {}
    if why := [*row.get("doubts", ())] or [text for text in [_without_path(row)] if text]:
        more["why"] = [text[:MAX_TEXT] for text in why]
    if said := said_of(tracks, confirmed):
        more["said"] = said
    if page := _link(out, row.get("output")):
        more["page"] = USUAL_PAGE if page == f"{os.path.splitext(name)[0]}.html" else page
    return [name, row.get("outcome"), round(stake, 2), doubts, sure, *short, more]


def said_of(tracks: Sequence[Mapping[str, Any]], confirmed: bool) -> str:
    """What of a trial is known and not found, in a few words; nothing where nothing is."""
    known = sum(track["reason"] == str(Reason.KNOWN) for track in tracks)
    count = f"{known} {'trajectory' if known == 1 else 'trajectories'} known" if known else ""
    return ", ".join(text for text in ("confirmed" if confirmed else "", count) if text)


def listed(doubts: Sequence[LabelDoubt], rate: float) -> list[list[Any]]:
    """The doubts of a trial, the longest first: label, frames, seconds, chance, cause, and what each could be."""
    longest = sorted(doubts, key=lambda doubt: (-doubt.points, doubt.frames))[:MAX_DOUBTS]
    return [
        [d.label, *d.frames, round(d.points / rate, 3), round(d.chance, 3), CAUSES.index(d.cause), *d.could_be]
        for d in longest
    ]


def _without_path(row: Mapping[str, Any]) -> str:
    """The message without the file that it begins with, which is named beside it."""
    message = row.get("message") or ""
    before, colon, after = message.partition(": ")
    return after if colon and os.path.basename(before) == os.path.basename(row.get("input") or "") else message


def _link(out: Path, output: str | None) -> str | None:
    """A link to the page of a result, whatever its name holds; None if it is not there, or older than the result."""
    if not output:
        return None
    result = out / output
    page = page_of_result(out, result)
    if not result.is_file() or not is_page(page) or page.stat().st_mtime < result.stat().st_mtime:
        return None
    return quote(os.fsencode(page.relative_to(out).as_posix()))
