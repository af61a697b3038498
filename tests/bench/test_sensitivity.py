"""How numbers are moved, what counts as moving nothing, and that rows which are there are skipped."""

from dataclasses import dataclass, field

import pytest
import sensitivity
from _moving import Outcome, figures, moved, moves, moves_nothing, unmoved, with_number
from takes import model, take

from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True)
class Few:
    width: float = field(default=2.0, metadata={"group": "a"})
    count: int = field(default=3, metadata={"group": "a"})
    starts: tuple[float, ...] = field(default=(1.0, 2.0), metadata={"group": "a"})
    nothing: float = field(default=0.0, metadata={"group": "a"})
    other: float = field(default=1.0, metadata={"group": "b"})

    def __post_init__(self):
        if self.count > 4:
            raise ValueError("count is at most 4")


@pytest.mark.parametrize(
    ("value", "less", "more"),
    [
        (2.0, 1.4, 2.8),
        (-10.0, -7.0, -14.0),
        (0.0, 0.0, 0.0),
        (1, 0, 2),
        (3, 2, 5),
        (100, 70, 140),
        (-1, 0, -2),
        (-10, -7, -14),
        (True, False, True),
        (False, True, False),
        ((1, 3), (0, 2), (2, 5)),
        ((0.82, 1.22, 10), (0.574, 0.854, 7), (1.148, 1.708, 14)),
        (((2.0, 0.0), (6.0,)), ((1.4, 0.0), (4.2,)), ((2.8, 0.0), (8.4,))),
        (None, None, None),
    ],
)
def test_how_a_number_is_moved(value, less, more):
    assert moved(value, 0.7) == less and moved(value, 1.4) == more
    assert type(moved(value, 0.7)) is type(value)


def test_every_number_is_moved_both_ways_and_alone():
    found = list(moves(Few(), leave=("b",)))
    assert found == [
        *[("width", 0.7, 1.4), ("width", 1.4, 2.8), ("count", 0.7, 2), ("count", 1.4, 5)],
        *[("starts", 0.7, (0.7, 1.4)), ("starts", 1.4, (1.4, 2.8))],
    ]
    assert with_number(Few(), "width", 1.4) == Few(width=1.4)
    assert unmoved(Few(), ("b",)) == ["nothing"] and "other" in {name for name, _, _ in moves(Few())}


def test_a_value_that_is_not_taken_is_said(monkeypatch):
    monkeypatch.setattr(sensitivity, "TUNING", Few())
    assert sensitivity.try_out("count", 5) == (None, "ValueError: count is at most 4")


DEFAULT = Outcome([1.0, 0.9], [1.0, 0.8], [100, 300], [{(0, 1): (9, 4, 0.9)}, {(2, 0): (5, NO_MATCH, 0.7)}])


@pytest.mark.parametrize(
    ("labels", "changed"),
    [
        ({(0, 1): (9, 4, 0.9)}, (0, 0)),
        ({(0, 1): (9, 5, 0.9)}, (1, 0)),
        ({(0, 1): (9, 4, 0.8)}, (0, 1)),
        ({(0, 1): (4, 4, 0.9), (4, 1): (9, 4, 0.9)}, (2, 0)),
        ({}, (1, 0)),
    ],
)
def test_what_counts_as_changed(labels, changed):
    other = Outcome([1.0, 0.5], [1.0, 0.6], [100, 301], [labels, DEFAULT.labels[1]])
    found = figures(other, DEFAULT)
    assert (found["labels_changed"], found["confidences_changed"], found["fits_changed"]) == (*changed, 1)
    assert (found["f1"], found["worst"], found["precision"], found["fits"]) == (0.75, 0.5, 0.8, 200)


def test_numbers_that_move_nothing():
    same = sensitivity.row("width", 0.7, 1.4, DEFAULT, DEFAULT)
    other = Outcome(DEFAULT.f1, DEFAULT.precision, [100, 301], DEFAULT.labels)
    fits = sensitivity.row("width", 1.4, 2.8, other, DEFAULT)
    failed = sensitivity.row("width", 1.4, 2.8, None, DEFAULT, "ValueError: no")
    assert moves_nothing([same]) and not moves_nothing([same, fits]) and not moves_nothing([same, failed])


def test_rows_that_are_there_are_skipped(tmp_path):
    path = tmp_path / "rows.csv"
    assert sensitivity.read(path) == []
    rows = [sensitivity.row("starts", factor, value, DEFAULT, DEFAULT) for factor, value in ((0.7, (0.7, 1.4)),)]
    sensitivity.write(path, [])
    sensitivity.append(path, rows[0])
    done = sensitivity.read(path)
    assert done == rows
    todo = [move for move in moves(Few(), ("b",)) if not sensitivity.is_done(move, done)]
    assert len(todo) == 5 and ("starts", 0.7, (0.7, 1.4)) not in todo
    assert not sensitivity.is_done(("starts", 0.7, (0.7, 1.5)), done)  # the default has changed since


def test_labels_of_a_recording_are_told_apart():
    found = next(sensitivity.label_many([take(3)[0]], [model()]))
    labels = sensitivity.labels_of(found)
    assert len(labels) == len(found.trajectories)
    assert sum(label != NO_MATCH for _, label, _ in labels.values()) == (found.identity != NO_MATCH).sum()
