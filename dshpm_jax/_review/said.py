"""What persons have said, against each other and against what changes besides."""

import math
from collections.abc import Sequence

import numpy as np

from dshpm_jax._corrections import Change, Correction, Corrections
from dshpm_jax._known import KnownLabel
from dshpm_jax._labelling import Labelling
from dshpm_jax._review import edits
from dshpm_jax._review.pieces import Effect
from dshpm_jax._types import NO_MATCH


def known_of(standing: Sequence[Correction]) -> tuple[KnownLabel, ...]:
    """What corrections say of which points; later ones count where two are of the same."""
    return Corrections("", "", tuple(standing)).known()


def superseded(standing: Sequence[Correction], said: Sequence[KnownLabel]) -> list[str]:
    """The ids of earlier corrections that say nothing but that other points have labels which these points have.

    Raises:
        ValueError: an earlier correction says that, and more.
    """
    gone = []
    for one in standing:
        clash = [any(_contradict(change.known, new) for new in said) for change in one.changes]
        if all(clash) and clash:
            gone.append(one.id)
        elif any(clash):
            label = next(change.label for change, wrong in zip(one.changes, clash, strict=True) if wrong)
            raise ValueError(
                f"you said before that {label} is another point in these frames; exchange the two, or undo"
            )
    return gone


def _contradict(old: KnownLabel, new: KnownLabel) -> bool:
    """Whether the label of one column is said of another at the same time."""
    apart = old.column == new.column or old.label is None or old.label != new.label
    old_last, new_last = (math.inf if one.last is None else one.last for one in (old, new))
    return not apart and old.first < new_last and new.first < old_last


def only(known: Sequence[KnownLabel]) -> Correction:
    """A correction that says nothing else."""
    return Correction("label", tuple(Change(k.column, k.first, k.last or k.first + 1, k.label) for k in known))


def said_again(labelling: Labelling, changes: Sequence[Change]) -> Labelling:
    """The labelling after changes that another program made, one after the other."""
    for change in changes:
        marker = NO_MATCH if change.label is None else labelling.model.markers.index(change.label)
        tracks, cells = labelling.trajectories, np.zeros(labelling.trajectories.index.shape, bool)
        some = slice(change.first, change.last)
        cells[some] = tracks.column[some] == labelling.recording.columns.index(change.column)
        labelling = edits.say(labelling, cells, marker).labelling
    return labelling


def covered(effect: Effect, known: Sequence[KnownLabel]) -> bool:
    """Whether an effect is of points of which something was said."""
    return any(
        one.column == effect.column and one.first <= effect.first and (one.last is None or effect.last <= one.last)
        for one in known
    )


def stays(effect: Effect, mine: Labelling) -> bool:
    """Whether what would have changed keeps its label if only the correction itself counts."""
    tracks, column = mine.trajectories, mine.recording.columns.index(effect.column)
    here = np.flatnonzero(tracks.column[effect.first] == column)
    number = mine.identity[tracks.index[effect.first, here[0]]] if len(here) else NO_MATCH
    return effect.was.label is not None and number != NO_MATCH and mine.model.markers[number] == effect.was.label


def as_it_was(effect: Effect) -> Change:
    """The change that keeps what an effect would have changed."""
    return Change(effect.column, effect.first, effect.last, effect.was.label, effect.was.label)
