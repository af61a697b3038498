"""Chosen numbers that say their unit, their use and what speaks for them."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from typing import Any


@dataclass(frozen=True)
class Number:
    """A chosen number of a tuning and what is known about it.

    Attributes:
        name: the field of the tuning.
        default: its value, of whatever type the field has.
        unit: "mm", "rad", "share", "count", ...
        used: where it is used and what it triggers, as "X: if value < this, Y".
        evidence: "paper", "derived: ...", "fitted: script, data" or "by hand" and why.
        group: the step of the method that it belongs to.
    """

    name: str
    default: Any
    unit: str
    used: str
    evidence: str
    group: str

    def __str__(self) -> str:
        return f"{self.unit}; used in {self.used}; {self.evidence}"


def number(default: Any, *, unit: str, used: str, evidence: str, group: str) -> Any:
    """A field of a frozen dataclass with a default and what is known about it (see `Number`).

    Raises:
        ValueError: one of the texts is empty.
    """
    known = {"unit": unit, "used": used, "evidence": evidence, "group": group}
    if empty := [key for key, text in known.items() if not text.strip()]:
        raise ValueError(f"the number {default!r} says nothing of its {', '.join(empty)}; give each a text")
    return field(default=default, metadata=known)


def numbers_of(tuning: Any) -> Iterator[Number]:
    """Every number of a tuning (a dataclass, or an object of one) in the order of its fields."""
    for one in fields(tuning):
        yield Number(one.name, one.default, **one.metadata)
