"""Known labels: nothing overrules them, the rest is labelled around them, and what cannot be is refused."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from takes import METHODS, model, shares, take, take_for

from dshpm_jax import KnownLabel, Reason, Recording
from dshpm_jax._driver import Driver
from dshpm_jax._known import known_points, latest
from dshpm_jax._label import label, label_many
from dshpm_jax._settings import Settings
from dshpm_jax._types import NO_MATCH, UNKNOWN

methods = pytest.mark.parametrize("method", METHODS)
SEED = 3


@cache
def labelled(method):
    return label(take_for(method, SEED), model(), Settings(method=method))


def named(marker: int) -> str | None:
    return None if marker == NO_MATCH else model().markers[marker]


def of_points(identities: np.ndarray) -> tuple[KnownLabel, ...]:
    """Known labels that say of every point what it is; a span for each unbroken run in a column."""
    found = []
    for column in range(identities.shape[1]):
        edges = [0, *(np.flatnonzero(np.diff(identities[:, column])) + 1).tolist(), len(identities)]
        found += [KnownLabel(column, a, b, named(int(identities[a, column]))) for a, b in zip(edges, edges[1:])]
    return tuple(found)


def true_labels() -> np.ndarray:
    return take(SEED)[1].numbered_by(model().markers)


def at_random(recording: Recording, rng: np.random.Generator, count: int) -> tuple[KnownLabel, ...]:
    """Labels given at random, most of them wrong: no two of a label, and spans of columns that are whole or not."""
    columns = rng.permutation(recording.points.shape[1])[:count]
    markers = rng.permutation(model().num_markers)
    found = []
    for column, marker in zip(columns.tolist(), markers.tolist()):
        first, last = np.sort(rng.choice(recording.num_frames + 1, 2, replace=False)).tolist()
        span = (first, last) if rng.random() < 0.5 else (0, None)
        found.append(KnownLabel(column, *span, named(marker if rng.random() < 0.7 else NO_MATCH)))
    return tuple(found)


def assert_kept(found, known):
    wanted = known_points(found.recording, model().markers, known)
    said = wanted != UNKNOWN
    np.testing.assert_array_equal(found.identities[said], wanted[said])
    reasons = np.array([reason == Reason.KNOWN for reason in found.reason])
    assert (found.confidence[reasons] == 1.0).all()
    columns = found.recording.points.shape[1]
    np.testing.assert_array_equal(found.trajectories.by_column(reasons.astype(np.int32), columns) == 1, said)
    for row in found.identities:
        assert len(row[row != NO_MATCH]) == len(set(row[row != NO_MATCH].tolist()))


@methods
@settings(max_examples=4, derandomize=True, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 30))
def test_nothing_overrules_them(method, seed, count):
    recording = take_for(method, SEED)
    known = at_random(recording, np.random.default_rng(seed), count)
    assert_kept(label(recording, model(), Settings(method=method), known=known), known)


@methods
def test_all_known_are_the_same_labels_out(method):
    before = labelled(method)
    known = of_points(before.identities)
    after = label(before.recording, model(), Settings(method=method), known=known)
    assert_kept(after, known)
    np.testing.assert_array_equal(after.identities, before.identities)


@methods
def test_the_order_of_points(method):
    recording = take_for(method, SEED)
    known = at_random(recording, np.random.default_rng(5), 8)
    order = np.random.default_rng(0).permutation(recording.points.shape[1])
    place = np.argsort(order)
    shuffled = Recording(recording.points[:, order], tuple(recording.labels[k] for k in order), recording.rate)
    moved = [replace(one, column=int(place[one.column])) for one in known]
    here = label(recording, model(), Settings(method=method), known=known).identities
    there = label(shuffled, model(), Settings(method=method), known=moved[::-1]).identities
    np.testing.assert_array_equal(there, here[:, order])


@methods
def test_right_ones_do_no_harm(method):
    recording, truth = take_for(method, SEED), true_labels()[: take_for(method, SEED).num_frames]
    known = [one for one in of_points(truth) if one.column % 5 == 0]
    after = label(recording, model(), Settings(method=method), known=known)
    before = shares(labelled(method).identities, recording, take(SEED)[1])[0]
    assert shares(after.identities, recording, take(SEED)[1])[0] >= before - 0.01


def test_wrong_ones_are_kept_and_said():
    recording, truth = take_for("full", SEED), true_labels()
    columns = [c for c in range(truth.shape[1]) if (truth[:, c] >= 0).sum() > 40][:2]
    a, b = (int(truth[truth[:, c] >= 0, c][0]) for c in columns)
    far = next(m for m in range(34) if m not in (a, b) and not (truth[:, columns] == m).any())
    lives = np.flatnonzero(truth[:, columns[0]] >= 0)
    found = label(recording, model(), known=[KnownLabel(columns[0], int(lives[0]), int(lives[-1]) + 1, named(far))])
    assert any(str(named(far)) in text and "do not lie like it" in text for text in found.stats["against"])


def test_company_in_the_batch():
    recordings = [take_for("full", SEED), take_for("full", SEED + 1)]
    known = [at_random(r, np.random.default_rng(k), 6) for k, r in enumerate(recordings)]
    together = label_many(recordings, model(), driver=Driver(in_flight=2), known=known)
    for recording, labels, found in zip(recordings, known, together, strict=True):
        np.testing.assert_array_equal(found.identities, label(recording, model(), known=labels).identities)


def test_a_span_splits_a_trajectory_at_its_ends():
    recording = take_for("full", SEED)
    lives = labelled("full").trajectories
    j = int(np.argmax(lives.stop - lives.start))
    first, last = int(lives.start[j]) + 10, int(lives.stop[j]) - 10
    column = int(lives.column[lives.start[j], lives.slot[j]])
    t = label(recording, model(), known=[KnownLabel(column, first, last, None)]).trajectories
    ends = {(int(a), int(b)) for a, b in zip(t.start, t.stop)}
    assert {(int(lives.start[j]), first), (first, last), (last, int(lives.stop[j]))} <= ends


def test_columns_are_those_of_the_file():
    recording = replace(take_for("paper", SEED), columns=tuple(range(5, take_for("paper", SEED).points.shape[1] + 5)))
    known = [KnownLabel(7, 0, None, "LKNE" if "LKNE" in model().markers else model().markers[3])]
    found = label(recording, model(), Settings(method="paper"), known=known)
    assert_kept(found, known)
    with pytest.raises(ValueError, match="column 2, .*: the recording has 60 frames"):
        label(recording, model(), known=[KnownLabel(2)])


def still(columns: int = 3, frames: int = 10) -> Recording:
    return Recording(np.zeros((frames, columns, 3)) + np.arange(columns)[:, None] * 100, ("",) * columns, 100.0)


MARKERS = ("A", "B", "C")


@pytest.mark.parametrize(
    ("known", "wrong"),
    [
        ([KnownLabel(0, 0, 5, "A"), KnownLabel(1, 4, 9, "A")], r"column 0, frames 0 to 4: A; column 1.*frame 4"),
        (
            [KnownLabel(0, 0, 5, "A"), KnownLabel(0, 4, 9, "B")],
            r"column 0.*: A; column 0.*: B: .* two labels",
        ),
        ([KnownLabel(0, 0, 5, "A"), KnownLabel(0, 4, 9)], r"one point two labels"),
        ([KnownLabel(0, label="Z")], "no marker of the model is called 'Z'; there are A, B, C"),
        ([KnownLabel(0, 0, 11, "A")], "the recording has 10 frames"),
        ([KnownLabel(0, 10, None, "A")], "the recording has 10 frames"),
        ([KnownLabel(3, 0, 5, "A")], "3 columns up to 2"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(known, wrong):
    with pytest.raises(ValueError, match=wrong) as raised:
        known_points(still(), MARKERS, known)
    assert "\n" not in str(raised.value)


def test_labels_that_take_turns_do_not_contradict_each_other():
    points = still().points.copy()
    points[5:, 0] = points[:5, 1] = np.nan
    found = known_points(Recording(points, ("",) * 3, 100.0), MARKERS, [KnownLabel(c, label="A") for c in (0, 1)])
    assert (found[:5, 0] == 0).all() and (found[5:, 1] == 0).all() and (found == UNKNOWN).sum() == 20


def with_names(found: Recording, names: dict[int, str]) -> Recording:
    return replace(found, labels=tuple(names.get(k, "") for k in range(len(found.labels))))


def test_names_of_the_file_are_kept():
    found, truth = take_for("paper", SEED), true_labels()
    whole = [c for c in range(truth.shape[1]) if len(set(truth[truth[:, c] >= 0, c])) == 1][:10]
    names = {c: str(named(int(truth[truth[:, c] >= 0, c][0]))) for c in whole}
    names[whole[0]], other = "no such marker", names[whole[0]]
    kept = label(with_names(found, names), model(), Settings(method="paper", keep_labels=True))
    assert_kept(kept, [KnownLabel(c, label=name) for c, name in names.items() if name != "no such marker"])
    only = Settings(method="paper", keep_labels=True, keep_frames=(10, 19))
    part = label(with_names(found, names), model(), only)
    spans = [KnownLabel(c, 10, 20, name) for c, name in names.items() if name in model().markers]
    assert_kept(part, spans)
    said = KnownLabel(whole[1], label=other)
    assert_kept(
        label(with_names(found, names), model(), Settings(method="paper", keep_labels=True), known=[said]),
        [said, *(KnownLabel(c, label=names[c]) for c in whole[2:])],
    )


def test_names_that_contradict_each_other_are_refused():
    found = take_for("paper", SEED)
    both = np.flatnonzero(found.present[0])[:2]
    with pytest.raises(ValueError, match="contradict each other"):
        label(
            with_names(found, dict.fromkeys(both.tolist(), "LKNE")), model(), Settings(method="paper", keep_labels=True)
        )


@pytest.mark.parametrize("frames", [(5, 4), (1,), (1.0, 2.0), "1:2"])
def test_frames_are_a_first_and_a_last_one(frames):
    with pytest.raises(ValueError, match="keep_frames"):
        Settings(keep_labels=True, keep_frames=frames)


def test_frames_go_with_names_that_are_kept():
    with pytest.raises(ValueError, match="keep_labels, which is not set"):
        Settings(keep_frames=(1, 2))


def test_of_one_point_and_one_label_the_last_counts():
    found = latest([KnownLabel(0, label="A"), KnownLabel(1, 5, 8, "A"), KnownLabel(0, 6, 10, None)])
    assert found == (
        KnownLabel(0, 0, 5, "A"),
        KnownLabel(0, 6, 10),
        KnownLabel(0, 10, None, "A"),
        KnownLabel(1, 5, 8, "A"),
    )
