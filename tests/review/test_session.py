"""What a person does to labels, kept line by line: it counts, is taken back, and is the same when opened again."""

import numpy as np
import pytest
from making import make_labelling, make_recording

from dshpm_jax import Labelling, Reason, Recording
from dshpm_jax._corrections import Correction
from dshpm_jax._known import KnownLabel
from dshpm_jax._review.pieces import Effect, adopted, after, difference, labels_at
from dshpm_jax._review.saying import effects_of, words
from dshpm_jax._review.session import Session, Stale
from dshpm_jax._types import NO_MATCH

MARKERS = ["A", "B", "C"]


class Kept:
    def __init__(self):
        self.lines: list[Correction] = []

    def append(self, correction: Correction) -> None:
        self.lines.append(correction)


def recording() -> Recording:
    """Four columns, seen throughout but for a gap in the third."""
    points = np.arange(30 * 4 * 3, dtype=float).reshape(30, 4, 3)
    points[10:15, 2] = np.nan
    return Recording(points, ("A", "B", "C", ""), 100.0, columns=(2, 4, 5, 7))


def session(solver=None) -> Session:
    return Session(make_labelling(recording(), MARKERS), Kept(), solver=solver)


def names(labelling: Labelling) -> list[list[str | None]]:
    """What the points of each column are called, frame by frame."""
    identities = labelling.identities
    return [[None if k == NO_MATCH else labelling.model.markers[k] for k in column] for column in identities.T]


def track(labelling: Labelling, column: int, frame: int) -> int:
    tracks = labelling.trajectories
    return int(tracks.index[frame, np.flatnonzero(tracks.column[frame] == column)[0]])


def assign(s: Session, column: int, frame: int, label: str | None, first=0, last=30) -> None:
    wanted = {"kind": "assign", "track": track(s.labelling, column, frame), "first": first, "last": last}
    s.propose({**wanted, "label": label})


def test_a_label_over_a_span_and_who_had_it_loses_it_there():
    s = session()
    assign(s, 3, 0, "B", 5, 12)
    assert s.proposal is not None and not s.log.lines  # B loses points, so it has to be accepted
    assert s.told() == {
        "text": "no label → B, frames 5–11",
        "others": [{"was": "B", "now": None, "frames": 7, "first": 5, "last": 11}],
    }
    s.accept()
    found = names(s.labelling)
    assert found[3] == [None] * 5 + ["B"] * 7 + [None] * 18
    assert found[1] == ["B"] * 5 + [None] * 7 + ["B"] * 18
    assert s.known() == (KnownLabel(7, 5, 12, "B"),)
    np.testing.assert_array_equal(s.labelling.recording.points, recording().points)


def test_what_changes_nothing_else_counts_at_once():
    s = session()
    assign(s, 2, 20, None)
    assert s.proposal is None and len(s.log.lines) == 1 and s.version == 1
    assert names(s.labelling)[2] == ["C"] * 10 + [None] * 20
    assert s.known() == (KnownLabel(5, 15, 30, None),)


def test_refused_it_never_was():
    s = session()
    before = names(s.labelling)
    assign(s, 3, 0, "B")
    s.refuse()
    assert names(s.labelling) == before and not s.log.lines and s.version == 0


def test_an_exchange_over_a_span():
    s = session()
    s.propose({"kind": "exchange", "one": "A", "other": "C", "first": 8, "last": 18})
    found = names(s.labelling)
    assert found[0] == ["A"] * 8 + ["C"] * 10 + ["A"] * 12
    assert found[2] == ["C"] * 8 + ["A"] * 2 + [None] * 5 + ["A"] * 3 + ["C"] * 12
    assert {(k.column, k.first, k.last, k.label) for k in s.known()} == {
        (2, 8, 18, "C"),
        (5, 8, 10, "A"),
        (5, 15, 18, "A"),
    }


def test_cut_join_confirm():
    s = session()
    s.propose({"kind": "cut", "track": track(s.labelling, 0, 0), "frame": 12})
    assert len(s.labelling.trajectories) == 6 and names(s.labelling)[0] == ["A"] * 30
    assert words(s.standing[-1]) == "cut A at frame 12"
    assign(s, 2, 20, None)
    s.propose({"kind": "merge", "track": track(s.labelling, 2, 20), "with": track(s.labelling, 2, 0)})
    assert names(s.labelling)[2] == ["C"] * 10 + [None] * 5 + ["C"] * 15
    s.propose({"kind": "confirm", "track": track(s.labelling, 1, 0)})
    assert s.standing[-1].kind == "confirm" and s.labelling.confidence[track(s.labelling, 1, 0)] == 1.0
    s.undo()
    assert s.labelling.confidence[track(s.labelling, 1, 0)] == 0.875


def some_corrections(s: Session) -> None:
    assign(s, 3, 0, "B", 5, 12)
    s.accept()
    s.propose({"kind": "cut", "track": track(s.labelling, 0, 0), "frame": 12})
    assign(s, 0, 20, "C", 12, 30)
    s.accept()
    s.propose({"kind": "exchange", "one": "A", "other": "B", "first": 0, "last": 4})


def test_undo_and_redo_lead_back_and_forth():
    s = session()
    states = [names(s.labelling)]
    some_corrections(s)
    for _ in range(4):
        states.append(names(s.labelling))
        s.undo()
    assert names(s.labelling) == states[0]
    assert len(s.labelling.trajectories) == len(make_labelling(recording(), MARKERS).trajectories)
    for k in range(4):
        s.redo()
        assert names(s.labelling) == states[4 - k]
    with pytest.raises(ValueError, match="nothing to do again"):
        s.redo()
    s.undo()
    s.propose({"kind": "confirm", "track": 0})
    with pytest.raises(ValueError, match="nothing to do again"):
        s.redo()


@pytest.mark.parametrize("applied", [0, 2, 4])
def test_labels_catch_up_with_their_corrections(applied):
    s = session()
    some_corrections(s)
    for _ in range(4 - applied):
        s.undo()
    base, ids = s.labelling, [one.id for one in s.standing]
    for _ in range(4 - applied):
        s.redo()
    again = Session(base, Kept(), list(s.lines))
    again.catch_up(ids)
    assert names(again.labelling) == names(s.labelling)
    back = Session(again.labelling, Kept(), list(s.lines))
    back.undo()
    back.undo()
    late = Session(again.labelling, Kept(), list(back.lines))
    late.catch_up([one.id for one in s.standing])
    assert names(late.labelling) == names(back.labelling)


def test_corrections_of_another_program_are_made_from_what_they_say():
    s = session()
    some_corrections(s)
    plain = [Correction(one.kind, one.changes, id=one.id) for one in s.standing if one.kind == "label"]
    other = Session(make_labelling(recording(), MARKERS), Kept(), plain)
    other.catch_up([])
    assert names(other.labelling) == names(s.labelling)


def test_effects_survive_json():
    import json

    s = session()
    some_corrections(s)
    for one in s.standing:
        plain = json.loads(json.dumps(dict(one.details)))
        assert [Effect.of(effect) for effect in plain.get("effects", ())] == effects_of(one)


def test_the_solver_is_asked_and_what_it_changes_is_shown():
    asked = []

    def solver(labelling, known):
        asked.append(known)
        note = np.full(labelling.trajectories.index.shape, -1)
        from dshpm_jax._review.pieces import Verdict, rewritten

        labels = labels_at(labelling)
        note[labels == 0], note[labels == 1] = 0, 1
        return rewritten(labelling, note, [Verdict(1, 0.9, Reason.MATCHED), Verdict(0, 1.0, Reason.KNOWN)])

    s = session(solver)
    assign(s, 1, 0, "A")
    assert asked == [(KnownLabel(4, 0, 30, "A"),)]
    assert [(e["was"], e["now"]) for e in (s.told() or {})["others"]] == [("A", "B")]
    s.accept(mine_only=True)
    assert names(s.labelling)[:2] == [[None] * 30, ["A"] * 30]
    s.undo()
    assign(s, 1, 0, "A")
    s.accept()
    assert names(s.labelling)[:2] == [["B"] * 30, ["A"] * 30]


def test_just_mine_keeps_the_others_for_good():
    def solver(labelling, known):
        from dshpm_jax._review.pieces import Verdict, rewritten

        note = np.full(labelling.trajectories.index.shape, -1)
        note[labels_at(labelling) == 2] = 0
        return rewritten(labelling, note, [Verdict(NO_MATCH, 0.9, Reason.TAKEN)])

    s = session(solver)
    assign(s, 3, 0, None)
    s.accept(mine_only=True)
    assert names(s.labelling)[2] == ["C"] * 10 + [None] * 5 + ["C"] * 15
    assert {(k.column, k.label) for k in s.known()} == {(7, None), (5, "C")}


def test_what_was_said_before_gives_way_or_is_named():
    s = session()
    assign(s, 3, 0, "B")
    s.accept()
    assign(s, 0, 0, "B")
    s.accept()
    assert s.known() == (KnownLabel(2, 0, 30, "B"),)
    s.propose({"kind": "exchange", "one": "C", "other": "B", "first": 0, "last": 30})
    with pytest.raises(ValueError, match="you said before that C is another point in these frames"):
        assign(s, 1, 0, "C")


@pytest.mark.parametrize(
    ("wanted", "why"),
    [
        ({"kind": "assign", "track": 99, "first": 0, "last": 3, "label": "A"}, "no such trajectory"),
        ({"kind": "assign", "track": True, "first": 3, "last": 3, "label": "A"}, "a span ends"),
        ({"kind": "assign", "track": 0, "first": 3, "last": 9, "label": "Z"}, "no marker of this trial"),
        ({"kind": "assign", "track": 0, "first": 80, "last": 90, "label": "A"}, "not seen in these frames"),
        ({"kind": "exchange", "one": "A", "other": "A", "first": 0, "last": 3}, "not one with itself"),
        ({"kind": "exchange", "one": "C", "other": "C", "first": 0, "last": 3}, "not one with itself"),
        ({"kind": "cut", "track": 0, "frame": 0}, "inside the trajectory"),
        ({"kind": "merge", "track": 0, "with": 1}, "at the same time"),
        ({"kind": "dance", "track": 0}, "nobody knows how to dance"),
    ],
)
def test_what_cannot_be_done_is_said(wanted, why):
    s = session()
    with pytest.raises(ValueError, match=why):
        s.propose(wanted)
    assert not s.log.lines


def test_a_page_that_is_behind_is_told_so():
    s = session()
    with s.at(0):
        s.propose({"kind": "cut", "track": 0, "frame": 4})
    with pytest.raises(Stale), s.at(0):
        pass


def test_labels_of_another_labelling_are_adopted_whatever_its_trajectories():
    mine = make_labelling(recording(), MARKERS)
    other = session()
    some_corrections(other)
    found = adopted(mine, other.labelling)
    assert names(found) == names(other.labelling)
    assert after(mine, difference(mine, found)).identity.tolist() == found.identity.tolist()
    assert names(after(found, difference(mine, found), back=True)) == names(mine)


def test_a_difference_is_nothing_without_one():
    mine = make_labelling(make_recording(40), ["LASI", "RASI"])
    assert difference(mine, mine) == []
