"""From what a file holds to a recording: columns that are no markers are left out, points that are none go missing, and
what is doubtful is said."""

from collections.abc import Sequence

import numpy as np

from dshpm_jax._geometry import is_seen
from dshpm_jax._recording import Recording, is_unlabelled
from dshpm_jax.io._computed import computed_points
from dshpm_jax.io._doubts import doubts
from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._held import held_points
from dshpm_jax.io._how import How
from dshpm_jax.io._known_outputs import known_outputs
from dshpm_jax.io._names import bare_labels, without_prefix
from dshpm_jax.io._raw import Raw

SHOWN = 8  # names in a note about many

MOST_COMPUTED = 2 / 3
"""Of the columns with a name; used in `_computed`: where more seem to be computed, a file of such points is meant."""


def judged(raw: Raw, how: How) -> Recording:
    """The recording that a file holds.

    Raises:
        ReadError: nothing is left of it.
    """
    if not raw.labels:
        raise ReadError(raw.path, "it holds no points", "export it with its trajectories")
    if not len(raw.points):
        raise ReadError(raw.path, "it holds no frames", "export it again")
    kept, notes = _kept(raw, how)
    points = raw.points[:, kept]
    if not is_seen(points).any():
        raise ReadError(raw.path, "not one point was seen in any frame", "export it with its trajectories")
    if how.frozen_gaps:
        held = held_points(points)
        points = np.where(held[..., None], np.nan, points)
        notes += _about_held(held)
    labels = bare_labels([raw.labels[c] for c in kept], raw.prefixes, how.unlabelled)
    notes += doubts(points, labels, raw.rate)
    columns = tuple(raw.columns[c] for c in kept)
    return Recording(points, labels, raw.rate, raw.unit, raw.path, columns, (*raw.notes, *notes))


def _kept(raw: Raw, how: How) -> tuple[list[int], list[str]]:
    """The columns that are taken for markers, and what to say about the others."""
    bare = [without_prefix(name, raw.prefixes) for name in raw.labels]
    said = [how.dropped((bare[c], name.strip()), raw.columns[c] + 1) for c, name in enumerate(raw.labels)]
    kept = [c for c in range(len(bare)) if not said[c]]
    if not kept:
        raise ReadError(raw.path, "all its points are left out", "leave fewer out with --drop")
    notes = [f"left out, as asked: {_shown([raw.labels[c] for c, out in enumerate(said) if out])}"] if any(said) else []
    computed = {c for c in _computed(raw, bare) if said[c] is None}
    if computed:
        names = _shown([raw.labels[c] for c in sorted(computed)])
        notes.append(f"left out, as computed from markers: {names} (--drop '!NAME' keeps one)")
    return [c for c in kept if c not in computed], notes


def _computed(raw: Raw, bare: Sequence[str]) -> set[int]:
    """Which columns hold points that some model computed, by their names, their marks and how they move."""
    named = [c for c, name in enumerate(bare) if not is_unlabelled(name)]
    listed = {named[k] for k in known_outputs([bare[c] for c in named])}
    rest = [c for c in named if c not in listed]
    exact = {rest[k] for k in np.flatnonzero(computed_points(raw.points[:, rest]))}
    marked = {c for c in rest if raw.unmeasured is not None and raw.unmeasured[c]}
    for found in (listed | exact | marked, listed):
        if len(found) <= MOST_COMPUTED * len(named):
            return found
    return set()


def _about_held(held: np.ndarray) -> list[str]:
    if not held.any():
        return []
    return [
        f"{int(held.sum())} points keep their coordinates to the last bit while others move: taken for gaps "
        "(--keep-frozen takes them for measured)"
    ]


def _shown(names: Sequence[str]) -> str:
    """Some names, and how many there are."""
    more = f", ... ({len(names)} in all)" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more
