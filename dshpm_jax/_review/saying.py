"""What was done to labels, in a few words for the page."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from dshpm_jax._corrections import Correction
from dshpm_jax._review.pieces import Effect, Place

SHOWN = 3  # labels that a line names; more are counted


def label_text(label: str | None) -> str:
    return "no label" if label is None else label


def words(correction: Correction) -> str:
    """What a correction did: `LKNE → LANK, frames 10–50`."""
    details = correction.details
    if correction.kind == "cut":
        return f"cut {label_text(details.get('label'))} at frame {details['frame']}"
    if correction.kind == "fill":
        verb = "filled" if details["accepted"] else "left open"
        return f"{details['marker']} {verb}, frames {details['first']}–{details['last'] - 1}"
    if correction.whole:
        return "all labels are right"
    if correction.kind == "confirm":
        said = dict.fromkeys("no marker" if c.label is None else c.label for c in correction.changes)
        return f"{_some(list(said))} right as it is"
    pairs = dict.fromkeys((c.was, c.label) for c in correction.changes)
    texts = [f"{label_text(was)} → {'no marker' if now is None else now}" for was, now in pairs]
    first = min((c.first for c in correction.changes), default=0)
    last = max((c.last for c in correction.changes), default=1) - 1
    return f"{_some(texts)}, frames {first}–{last}"


def effects_of(correction: Correction) -> list[Effect]:
    """What a correction changed when it was made."""
    return [Effect.of(plain) for plain in correction.details.get("effects", ())]


def cuts_of(correction: Correction) -> list[Place]:
    """Where a correction cut trajectories when it was made."""
    return [(int(column), int(frame)) for column, frame in correction.details.get("cuts", ())]


def told(effects: Iterable[Effect]) -> list[dict[str, Any]]:
    """Effects as the page lists them: those of one label together, the longest first."""
    found: dict[tuple[str | None, str | None], dict[str, Any]] = {}
    for effect in effects:
        if effect.was.label == effect.now.label:
            continue
        pair = effect.was.label, effect.now.label
        one = found.setdefault(pair, {"was": pair[0], "now": pair[1], "frames": 0, "first": effect.first, "last": 0})
        one["frames"] += effect.last - effect.first
        one["first"], one["last"] = min(one["first"], effect.first), max(one["last"], effect.last - 1)
    return sorted(found.values(), key=lambda one: -one["frames"])


def history(standing: Sequence[Correction], undone: Sequence[Correction]) -> list[Mapping[str, Any]]:
    """What stands and what can be done again, in order."""
    lines = [(one, True) for one in standing] + [(one, False) for one in reversed(undone)]
    return [{"text": words(one), "time": one.time, "by": one.by, "stands": stands} for one, stands in lines]


def _some(texts: list[str]) -> str:
    return ", ".join(texts[:SHOWN]) + (f" and {len(texts) - SHOWN} more" if len(texts) > SHOWN else "")
