"""Names of columns: with or without the subject's prefix, and those that count as none."""

from collections import Counter
from collections.abc import Collection, Sequence
from fnmatch import fnmatchcase
from itertools import count

import numpy as np
from jaxtyping import Int

from dshpm_jax._recording import bare_label, is_unlabelled
from dshpm_jax._types import NO_MATCH


def without_prefix(name: str, prefixes: Sequence[str] = ()) -> str:
    """A label without the subject's prefix; `prefixes` are those of the file besides what ends in a colon."""
    return bare_label(name.removeprefix(next(filter(name.startswith, prefixes), "")))


def bare_labels(labels: Sequence[str], prefixes: Sequence[str] = (), unlabelled: Sequence[str] = ()) -> tuple[str, ...]:
    """Labels without subject prefixes; with them where two subjects wear markers of the same names.

    Arguments:
        prefixes: what comes before labels in this file, besides what ends in a colon.
        unlabelled: names, with wildcards, that count as none; with or without their prefix.
    """
    bare = [without_prefix(name, prefixes) for name in labels]
    whole = [name.strip() for name in labels]
    for k, both in enumerate(zip(bare, whole)):
        if any(fnmatchcase(name, pattern) for name in both for pattern in unlabelled):
            bare[k] = whole[k] = ""
    return tuple(min((bare, whole), key=_twice))


def _twice(names: Sequence[str]) -> int:
    """How many columns have the name of one before."""
    named = [name for name in names if not is_unlabelled(bare_label(name))]
    return len(named) - len(Counter(named))


def names_as_before(
    markers: Sequence[str],
    left: Int[np.ndarray, "frames columns"],
    labels: Sequence[str],
    prefixes: Sequence[str] = (),
    keep_unknown: bool = False,
) -> list[str]:
    """Names for the markers and the unlabelled columns of a result, in the spelling of its source.

    Markers have the subject's prefix that they had, or that of all others. A column that stays without a name keeps the
    number that the capture system gave it, and a new one gets the next `*1`, `*2`, ... that is free.

    Arguments:
        left: for each unlabelled column the source's column in each frame, `NO_MATCH` where none.
        labels: of the source's columns.
        prefixes: what comes before labels in this file, besides what ends in a colon.
        keep_unknown: whether unlabelled columns keep names that are none of the markers'.
    """
    whole = [label.strip() for label in labels]
    bare = [without_prefix(label, prefixes) for label in labels]
    named = [k for k, name in enumerate(bare) if not is_unlabelled(name)]
    times = Counter(bare[k] for k in named)
    spelt = {bare[k]: whole[k] for k in named if times[bare[k]] == 1}
    before = {whole[k].removesuffix(bare[k]) for k in named}
    shared = before.pop() if len(before) == 1 else ""
    names = [spelt.get(marker, marker if ":" in marker else shared + marker) for marker in markers]
    free = (name for k in count(1) if (name := f"*{k}") not in whole)
    taken = {*markers, *names}
    for column in left.T:
        points = np.unique(column[column != NO_MATCH])
        old = int(points[0]) if len(points) == 1 else None
        kept = old is not None and whole[old] and _is_kept(whole[old], bare[old], taken, keep_unknown)
        names.append(whole[old] if kept and old is not None else next(free))
    return names


def _is_kept(whole: str, bare: str, taken: Collection[str], keep_unknown: bool) -> bool:
    """Whether an unlabelled column keeps its name: one of the system's own, or one that no marker has."""
    return is_unlabelled(bare) or (keep_unknown and whole not in taken and bare not in taken)
