"""Corrections beside a result: what was appended is read, whatever a crash leaves behind."""

import multiprocessing
import time

import numpy as np
import pytest

from dshpm_jax import Recording, io, write_c3d
from dshpm_jax._corrections import (
    Change,
    Correction,
    Corrections,
    CorrectionsError,
    Locked,
    append,
    check_belongs,
    corrections_path,
    locked,
    read_corrections,
)
from dshpm_jax._known import KnownLabel


@pytest.fixture
def recording(tmp_path):
    points = np.random.default_rng(0).normal(size=(5, 4, 3)) * 500
    path = tmp_path / "walk.c3d"
    write_c3d(Recording(points, ("A", "B", "C", "*1"), 100.0), path)
    return path


@pytest.fixture
def kept(tmp_path):
    return corrections_path(tmp_path / "labelled" / "walk.c3d")


def is_label(column, first, last, label, was=None) -> Correction:
    return Correction("label", (Change(column, first, last, label, was),))


def of(*corrections) -> Corrections:
    return Corrections("walk.c3d", "", corrections)


def test_what_was_appended_is_read(recording, kept):
    kept.parent.mkdir()
    first = Correction("label", (Change(0, 0, 5, "B", "A"), Change(1, 0, 5, "A", "B")), by="Änne")
    lines = first, Correction("undo", of=first.id), Correction("redo", of=first.id), Correction("confirm", whole=True)
    for line in lines:
        append(kept, line, recording)
    found = read_corrections(kept)
    assert found is not None and found.lines == lines and not found.torn
    assert (found.recording, found.confirmed) == ("walk.c3d", True)
    check_belongs(found, kept, recording)


def test_no_file_is_no_corrections(kept):
    assert read_corrections(kept) is None


@pytest.mark.parametrize("left", [1, 20, 60])
def test_a_line_that_a_crash_cut_off_never_counted(recording, tmp_path, left):
    path = tmp_path / "walk.corrections.jsonl"
    one, two = is_label(0, 0, 5, "B"), is_label(1, 0, 5, "A")
    append(path, one, recording)
    with path.open("ab") as file:
        file.write(b'{"id": "1", "time": "2026", "kind": "label", "changes": [{"column"'[:left])
    found = read_corrections(path)
    assert found is not None and found.torn and found.lines == (one,)
    append(path, two, recording)
    found = read_corrections(path)
    assert found is not None and not found.torn and found.lines == (one, two)


def test_a_head_that_a_crash_cut_off_is_written_anew(recording, tmp_path):
    path = tmp_path / "walk.corrections.jsonl"
    path.write_bytes(b'{"format": "dshpm-corr')
    append(path, is_label(0, 0, 5, "B"), recording)
    found = read_corrections(path)
    assert found is not None and len(found.lines) == 1


@pytest.mark.parametrize("line", [b"{}", b"[1]", b"x", b'{"id": "1", "time": "", "kind": "label", "changes": [{}]}'])
def test_other_damage_is_refused_in_one_line_and_nothing_is_added(recording, tmp_path, line):
    path = tmp_path / "walk.corrections.jsonl"
    append(path, is_label(0, 0, 5, "B"), recording)
    path.write_bytes(path.read_bytes() + line + b"\n")
    before = path.read_bytes()
    for act in (lambda: read_corrections(path), lambda: append(path, is_label(0, 0, 5, "A"), recording)):
        with pytest.raises(CorrectionsError, match=r"walk\.corrections\.jsonl: line 3 .*; mend that line") as raised:
            act()
        assert "\n" not in str(raised.value)
    assert path.read_bytes() == before


def test_files_of_somebody_else_are_refused(recording, tmp_path):
    path = tmp_path / "walk.corrections.jsonl"
    path.write_text('{"format": "other"}\n')
    with pytest.raises(CorrectionsError, match="none of our files"):
        append(path, is_label(0, 0, 5, "B"), recording)
    assert path.read_text() == '{"format": "other"}\n'


def test_they_belong_to_points_whatever_these_are_called(recording, tmp_path):
    path = tmp_path / "walk.corrections.jsonl"
    append(path, is_label(0, 0, 5, "B"), recording)
    found = read_corrections(path)
    assert found is not None
    read = io.read(recording)
    renamed, moved = tmp_path / "renamed.c3d", tmp_path / "moved.c3d"
    write_c3d(Recording(read.points, ("X", "Y", "Z", "*1"), 100.0), renamed)
    write_c3d(Recording(read.points + 1.0, read.labels, 100.0), moved)
    check_belongs(found, path, renamed)
    with pytest.raises(CorrectionsError, match=r"holds corrections of walk\.c3d, and .*moved\.c3d has other points"):
        check_belongs(found, path, moved)


def test_later_corrections_count_where_they_overlap():
    found = of(is_label(0, 0, 100, "A"), is_label(0, 20, 30, "B"), is_label(0, 25, 40, None), is_label(2, 0, 9, "A"))
    expected = [(0, 9, 20, "A"), (0, 20, 25, "B"), (0, 25, 40, None), (0, 40, 100, "A"), (2, 0, 9, "A")]
    assert found.known() == tuple(KnownLabel(*one) for one in expected)


def test_what_was_undone_does_not_count_until_it_is_redone():
    one, two = is_label(0, 0, 9, "A"), is_label(1, 0, 9, "B")
    undo = [Correction("undo", of=x.id) for x in (two, one)]
    redo = [Correction("redo", of=x.id) for x in (one, two)]
    assert of(one, two, *undo).known() == () and of(one, two, *undo).undoable is None
    assert of(one, two, *undo).redoable == one
    assert of(one, two, *undo, *redo).known() == of(one, two).known()
    assert of(one, two, undo[0]).undoable == one and of(one, two, undo[0]).redoable == two
    assert of(one, two, undo[0], is_label(2, 0, 9, "C")).redoable is None


def test_an_undo_of_what_is_not_there_changes_nothing():
    one = is_label(0, 0, 9, "A")
    assert of(one, Correction("undo", of="nothing"), Correction("redo", of=one.id)).standing == (one,)


def test_one_holds_the_lock_at_a_time(tmp_path):
    with locked(tmp_path / "lock"):
        with pytest.raises(Locked, match="another program"):
            with locked(tmp_path / "lock"):
                pass
    with locked(tmp_path / "lock"):
        pass


def _hold(path, ready):
    with locked(path):
        ready.set()
        time.sleep(1e3)


def test_a_process_that_dies_holds_no_lock(tmp_path):
    context = multiprocessing.get_context("spawn")
    ready = context.Event()
    process = context.Process(target=_hold, args=(tmp_path / "lock", ready))
    process.start()
    assert ready.wait(60)
    with pytest.raises(Locked):
        with locked(tmp_path / "lock"):
            pass
    process.kill()
    process.join()
    with locked(tmp_path / "lock"):
        pass


@pytest.mark.parametrize("span", [{"column": -1}, {"column": 0, "first": -1}, {"column": 0, "first": 5, "last": 5}])
def test_spans_that_cannot_be_are_refused(span):
    with pytest.raises(ValueError, match="count from 0"):
        KnownLabel(**span)
