"""Which recording is the wrong one, told by a stand-in for `check`."""

import sys
from types import SimpleNamespace

import pytest
from making import make_recording

from dshpm_jax import Finding, SubjectModel
from dshpm_jax._model_choice.wrong_labels import FOLDS, find_wrong_labels

LABELS = ("LASI", "RASI", "SACR")


@pytest.fixture
def judged(monkeypatch):
    """`check` contradicts a recording by its distance from those of the model; the calls that were made of it.

    The number of a recording is its number of frames less 60; those from 50 on are wrong.
    """
    calls = []

    def check(recording, model):
        number = recording.num_frames - 60
        calls.append((number, model))
        unlike = sum((other >= 50) != (number >= 50) for other in model)
        evidence = 100.0 * unlike / len(model)
        return [Finding("LASI", 0, 0, 59, "RASI", evidence)] if evidence > 20 else []

    monkeypatch.setitem(sys.modules, "dshpm_jax._check", SimpleNamespace(check=check))
    monkeypatch.setattr(SubjectModel, "from_recordings", lambda others: {r.num_frames - 60 for r in others})
    return calls


def verdict(*numbers):
    return find_wrong_labels([make_recording(60 + number, LABELS) for number in numbers])


def test_sound_ones_are_kept_and_each_is_judged_once_by_others_alone(judged):
    assert verdict(*range(12)).kept == list(range(12))
    assert sorted(number for number, _ in judged) == list(range(12))
    assert all(number not in model for number, model in judged)
    assert len({frozenset(model) for _, model in judged}) == FOLDS


@pytest.mark.parametrize("numbers", [(0, 1, 50), (50, 0, 1), (0, 50, 1, 2, 51, 3, 4), (*range(8), 50, 51)])
def test_the_few_that_are_unlike_the_others_are_left_out(judged, numbers):
    found = verdict(*numbers)
    assert [numbers[k] for k in found.kept] == [n for n in numbers if n < 50] and not found.undecided
    assert {numbers[k] for k in found.wrong} == {n for n in numbers if n >= 50}
    assert set(found.wrong.values()) == {"LASI, frames 0-59, should be RASI"}


def test_two_alone_are_left_to_people(judged):
    found = verdict(0, 50)
    assert found.kept == [0, 1] and not found.wrong and found.undecided.keys() == {0, 1}


def test_what_harms_no_model_is_no_reason(judged, monkeypatch):
    findings = [
        Finding("LASI", 0, 3, 3, "RASI", 99.0),  # too short
        Finding("*4", 3, 0, 59, "RASI", 99.0),  # a label that is lacking
    ]
    monkeypatch.setitem(sys.modules, "dshpm_jax._check", SimpleNamespace(check=lambda r, m: findings))
    recordings = [make_recording(200 + k, (*LABELS, "*4")) for k in range(3)]
    assert find_wrong_labels(recordings).kept == [0, 1, 2]


def test_others_that_cannot_judge_are_no_reason(monkeypatch):
    def check(recording, model):
        raise ValueError("none of its labels is in the model")

    monkeypatch.setitem(sys.modules, "dshpm_jax._check", SimpleNamespace(check=check))
    assert find_wrong_labels([make_recording(60 + k, LABELS) for k in range(3)]).kept == [0, 1, 2]
