"""Which markers are the left and the right of one another, by their names."""

import re
from collections.abc import Sequence

_OTHER = {"left": "right", "l": "r"}
_LEFT = (
    re.compile(r"(?P<before>(?:.*:)?)(?P<side>left|l)(?P<after>.+)", re.IGNORECASE),
    re.compile(r"(?P<before>.+[_. -])(?P<side>left|l)(?P<after>\d*)", re.IGNORECASE),
)


def sides(names: Sequence[str]) -> list[list[int]]:
    """Pairs of places in `names`: a left marker, and the right one whose name differs in nothing but the side.

    Of several subjects only those of the first, as they may face different ways.
    """
    place = {name.lower(): k for k, name in enumerate(names)}
    pairs: list[list[int]] = []
    for k, name in enumerate(names):
        found = (_other(match) for pattern in _LEFT if (match := pattern.fullmatch(name)))
        if partner := next((text for text in found if text in place), None):
            pairs.append([k, place[partner]])
    return [pair for pair in pairs if _subject(names[pair[0]]) == _subject(names[pairs[0][0]])]


def _subject(name: str) -> str:
    return name.rpartition(":")[0]


def _other(left: re.Match[str]) -> str:
    """The name on the right, in small letters."""
    return (left["before"] + _OTHER[left["side"].lower()] + left["after"]).lower()
