"""A correction solved anew: what was there stays, what it says holds, and one mends what hangs together."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from takes import model, shares, take, take_for

from dshpm_jax import KnownLabel, Labelling, Reason, correct, label
from dshpm_jax._types import NO_MATCH

SEED = 3


@cache
def labelled() -> Labelling:
    return label(take_for("full", SEED), model())


def spans(found: Labelling, which: np.ndarray, marker: str | None) -> list[KnownLabel]:
    """Whole trajectories as known labels."""
    t = found.trajectories
    rows = [(int(t.column[t.start[j], t.slot[j]]), int(t.start[j]), int(t.stop[j])) for j in which]
    return [KnownLabel(*row, marker) for row in rows]


def exchanged(found: Labelling, a: str, b: str) -> Labelling:
    """The labelling with all labels of two segments exchanged, marker by marker."""
    segments = {segment.name: segment.markers for segment in found.model.segments}
    to = np.arange(found.model.num_markers + 1)
    to[-1] = NO_MATCH
    to[list(segments[a])], to[list(segments[b])] = segments[b], segments[a]
    return replace(found, identity=to[found.identity].astype(np.int32))


def test_without_any_the_labels_stay():
    np.testing.assert_array_equal(correct(labelled(), []).identities, labelled().identities)


def test_what_is_known_holds_and_the_rest_stays():
    before = labelled()
    which = int(np.argmax(before.trajectories.stop - before.trajectories.start))
    known = spans(before, np.array([which]), None)
    after = correct(before, known)
    changed = (after.identities != before.identities).any(0)
    assert changed[known[0].column] and changed.sum() <= 2
    assert after.reason.count(Reason.KNOWN) == 1


def test_one_label_mends_a_wrong_limb():
    """Both forearms with each other's labels fit themselves; one label that is known tells them apart."""
    names = sorted(segment.name for segment in model().segments)
    sides = [(a, b) for a in names for b in names if a < b and a.replace("left", "right") == b]
    recording, truth = take(SEED)
    for a, b in sides:
        wrong = exchanged(labelled(), a, b)
        right = labelled()
        moved = np.flatnonzero((wrong.identity != right.identity) & (right.identity != NO_MATCH))
        longest = moved[np.argmax((right.trajectories.stop - right.trajectories.start)[moved])]
        name = model().markers[right.identity[longest]]
        after = correct(wrong, spans(right, np.array([longest]), name))
        assert shares(after.identities, recording, truth)[0] >= shares(right.identities, recording, truth)[0] - 0.01


def test_a_label_taken_for_a_while_stays_before_and_after():
    before = labelled()
    t, life = before.trajectories, before.trajectories.stop - before.trajectories.start
    which = next(j for j in np.argsort(-life) if before.identity[j] != NO_MATCH)
    first, last = int(t.start[which]) + 20, int(t.stop[which]) - 20
    free = np.flatnonzero((before.identity == NO_MATCH) & (t.start < last) & (t.stop > first))
    other = int(free[np.argmax(np.minimum(t.stop[free], last) - np.maximum(t.start[free], first))])
    span = max(first, int(t.start[other])), min(last, int(t.stop[other]))
    column = int(t.column[t.start[other], t.slot[other]])
    after = correct(before, [KnownLabel(column, *span, model().markers[before.identity[which]])])
    held = int(t.column[t.start[which], t.slot[which]])
    outside = np.r_[int(t.start[which]) : span[0], span[1] : int(t.stop[which])]
    assert (after.identities[span[0] : span[1], column] == before.identity[which]).all()
    assert (after.identities[outside, held] == before.identity[which]).all()


def test_contradictions_are_refused():
    with pytest.raises(ValueError, match="contradict each other"):
        correct(labelled(), [KnownLabel(0, label=None), KnownLabel(0, label=model().markers[0])])
