"""How a number is moved, and what labelling becomes by it; numbers, switches and tuples of them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

FACTORS = 0.7, 1.4
Labels = dict[tuple[int, int], tuple[int, int, float]]
"""For the first frame and column of each trajectory its end, label and confidence."""


@dataclass(frozen=True)
class Outcome:
    """What labelling some recordings gave, an entry each.

    Attributes:
        f1, precision: over points.
        fits: rigid fits.
        labels: of the trajectories.
    """

    f1: list[float]
    precision: list[float]
    fits: list[int]
    labels: list[Labels]


def moved(value: Any, factor: float) -> Any:
    """`value` times `factor`; `value` itself if it cannot be moved.

    Whole numbers go on to the next away from where they were, elements of tuples each for itself. A switch is turned
    by a factor below one, and stays with any other, as it has no second place to go to.
    """
    if isinstance(value, bool):
        return value != (factor < 1)
    if isinstance(value, int):
        away = math.floor if (factor < 1) == (value > 0) else math.ceil
        return value if value == 0 else _beyond(value, away(value * factor), factor)
    if isinstance(value, float):
        return float(f"{value * factor:.12g}")
    if isinstance(value, tuple):
        return tuple(moved(one, factor) for one in value)
    return value


def _beyond(value: int, found: int, factor: float) -> int:
    """`found`, or the next whole number in that direction."""
    if found != value:
        return found
    return value + (1 if (factor > 1) == (value > 0) else -1)


def moves(tuning: Any, leave: tuple[str, ...] = ()) -> Iterator[tuple[str, float, Any]]:
    """The name, the factor and the new value of every move of a number that is not of a group to leave out."""
    for one in fields(tuning):
        for factor in FACTORS if one.metadata.get("group") not in leave else ():
            value = getattr(tuning, one.name)
            if (new := moved(value, factor)) != value:
                yield one.name, factor, new


def unmoved(tuning: Any, leave: tuple[str, ...] = ()) -> list[str]:
    """The numbers that no factor moves, such as zero."""
    named = {name for name, _, _ in moves(tuning)}
    return [one.name for one in fields(tuning) if one.metadata.get("group") not in leave and one.name not in named]


def with_number(tuning: Any, name: str, value: Any) -> Any:
    """The tuning with another value of one number; a `ValueError` where it does not take it."""
    return replace(tuning, **{name: value})


def figures(outcome: Outcome, default: Outcome) -> dict[str, float | int]:
    """What a row holds: scores, rigid fits, and trajectories whose label or confidence is not that by default."""
    changed = [_changed(one, other) for one, other in zip(outcome.labels, default.labels, strict=True)]
    return {
        "f1": round(float(np.mean(outcome.f1)), 5),
        "worst": round(min(outcome.f1), 5),
        "precision": round(float(np.nanmean(outcome.precision)), 5),
        "fits": int(np.median(outcome.fits)),
        "labels_changed": sum(labels for labels, _ in changed),
        "confidences_changed": sum(confidences for _, confidences in changed),
        "fits_changed": sum(one != other for one, other in zip(outcome.fits, default.fits)),
    }


def _changed(one: Labels, other: Labels) -> tuple[int, int]:
    """Trajectories with another label, end or beginning, and those of which only the confidence moved."""
    labels = confidences = 0
    for key in one.keys() | other.keys():
        (stop, label, sure), (stop_then, label_then, sure_then) = (of.get(key, (-1, -2, 0.0)) for of in (one, other))
        labels += (stop, label) != (stop_then, label_then)
        confidences += (stop, label) == (stop_then, label_then) and abs(sure - sure_then) > 1e-6
    return labels, confidences


def moves_nothing(rows: list[dict[str, str]]) -> bool:
    """Whether no move of a number changed a label, a confidence or a count of fits; an error counts as a change."""
    return all(not row["error"] and all(int(row[key]) == 0 for key in row if key.endswith("_changed")) for row in rows)
