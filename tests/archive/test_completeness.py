"""Completeness on made cases: what a technician calls complete reads 100 %, and what is lost counts."""

import json
from dataclasses import replace

import numpy as np
import pytest
from making import make_labelling, make_model, make_recording

from dshpm_jax import Labelling, Reason, Recording, combine_models, io
from dshpm_jax._archive.completeness import Lives, completeness, never_seen, percent
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH

FRAMES, RATE = 400, 100.0
MARKERS = [*"ABCDEFGH"]
FULL = {"model_fit": 1.0}  # what only the full method says


def labelling(seen, identity, reason=Reason.OUTSIDE, could_be=None, markers=MARKERS, stats=FULL) -> Labelling:
    """A column a trajectory or more, seen where `seen` says so.

    Arguments:
        identity, could_be: the marker of each column, and what else it may be.
        reason: of columns without a label.
    """
    places = np.random.default_rng(1).uniform(-500, 500, (1, seen.shape[1], 3))
    points = np.where(seen[..., None], np.broadcast_to(places, (*seen.shape, 3)), np.nan)
    recording = Recording(points, tuple(f"*{k}" for k in range(seen.shape[1])), RATE)
    tracks = from_columns(points, RATE)
    column = tracks.column[tracks.start, tracks.slot]
    given = np.array(identity)[column]
    reasons = tuple(reason if k == NO_MATCH else Reason.MATCHED for k in given)
    other = np.full((len(tracks), 2), NO_MATCH)
    if could_be is not None:
        other[:, 0] = np.array(could_be)[column]
    model = make_model(markers)
    return Labelling(recording, model, tracks, given, np.full(len(tracks), 0.9), reasons, dict(stats), other)


def everywhere(columns: int) -> np.ndarray:
    return np.ones((FRAMES, columns), bool)


def found(labelling: Labelling, path) -> tuple[float, list[str]]:
    """By the labelling; a sidecar says the same."""
    lives = Lives.of(labelling)
    io.write_sidecar(labelling, path)
    sidecar = io.read_sidecar(path, column_runs=False)
    assert sidecar is not None
    again = Lives.of_sidecar(sidecar)
    assert (completeness(again), never_seen(again)) == (completeness(lives), never_seen(lives))
    return completeness(lives), never_seen(lives)


@pytest.fixture
def sidecar(tmp_path):
    return tmp_path / "walk.labels.json"


def test_gaps_and_false_points_are_no_loss(sidecar):
    rng = np.random.default_rng(0)
    seen = everywhere(12)
    for column in range(8):
        for start in rng.integers(0, FRAMES - 60, 3):
            seen[start : start + 60, column] = False
    seen[:, 8:] = False
    for column in range(8, 12):  # false points, the last in the very gap of a marker
        seen[100 * (column - 8) : 100 * (column - 8) + 90, column] = True
    seen[310:380, 7] = False
    seen[310:380, 11], seen[:310, 11], seen[380:, 11] = True, False, False
    assert found(labelling(seen, [*range(8), *[NO_MATCH] * 4]), sidecar) == (1.0, [])


def test_an_empty_volume_is_no_loss(sidecar):
    seen = everywhere(8)
    seen[150:] = False
    assert found(labelling(seen, range(8)), sidecar) == (1.0, [])


def test_a_lower_body_alone_is_complete_and_what_is_not_worn_is_said(sidecar):
    assert found(labelling(everywhere(4), range(4)), sidecar) == (1.0, [*"EFGH"])


def test_labels_withheld_are_lost(sidecar):
    identity = [0, 1, 2, 3, *[NO_MATCH] * 4]
    withheld = labelling(everywhere(8), identity, Reason.DOUBTFUL, could_be=[*[NO_MATCH] * 4, 4, 5, 6, 7])
    assert found(withheld, sidecar) == (0.5, [*"EFGH"])
    taken = labelling(everywhere(8), identity, Reason.TAKEN, could_be=[*[NO_MATCH] * 4, 0, 1, 2, 3])
    assert found(taken, sidecar)[0] == 1.0  # other points have these labels


def test_a_label_withheld_counts_in_the_frames_without_it(sidecar):
    seen = everywhere(9)
    seen[:100, 7] = False
    one = labelling(seen, [*range(8), NO_MATCH], Reason.AMBIGUOUS, could_be=[*[NO_MATCH] * 8, 7])
    assert found(one, sidecar)[0] == pytest.approx(3100 / 3200, abs=1e-4)


def test_points_that_may_be_a_marker_that_nobody_found_are_lost(sidecar):
    """Three of eight are found and five long trajectories are left, as with the model of somebody else."""
    assert found(labelling(everywhere(8), [0, 1, 2, *[NO_MATCH] * 5]), sidecar)[0] == 0.375
    # There are more of them than markers that may be missing: those of a chair, say.
    assert found(labelling(everywhere(12), [*range(7), *[NO_MATCH] * 5]), sidecar)[0] == 0.875
    short = everywhere(8)
    short[90:, 3:] = False  # too short to be markers
    assert found(labelling(short, [0, 1, 2, *[NO_MATCH] * 5]), sidecar)[0] == 1.0


def test_a_marker_that_is_lost_for_good_counts_a_second_later(sidecar):
    seen = everywhere(9)
    seen[150:, 7], seen[:150, 8] = False, False
    expected = (7 * 400 + 150) / (7 * 400 + 150 + 150)
    assert found(labelling(seen, [*range(8), NO_MATCH]), sidecar)[0] == pytest.approx(expected, abs=0.002)


def test_methods_without_evidence_lose_every_point_that_has_a_marker_left(sidecar):
    one = labelling(everywhere(8), [*range(6), *[NO_MATCH] * 2], Reason.ABANDONED, stats={})
    assert found(one, sidecar)[0] == 0.75
    assert found(replace(one, could_be=None), sidecar)[0] == 0.75


def test_two_people_of_whom_one_is_absent(sidecar):
    model = combine_models({"ann": make_model([*"AB"]), "bob": make_model([*"AB"])})
    seen = everywhere(3)
    seen[60:, 2] = False  # a false point
    one = labelling(seen, [2, 3, NO_MATCH], markers=list(model.markers))
    assert found(one, sidecar) == (1.0, ["ann:A", "ann:B"])


def test_nothing_labelled_is_nothing_complete(sidecar):
    assert found(labelling(everywhere(2), [NO_MATCH] * 2), sidecar) == (0.0, MARKERS)


def test_real_files_and_sidecars_agree(sidecar):
    recording = make_recording(100)
    for names in (["LASI", "RASI", "SACR"], ["LASI", "NOSE"]):
        share, _ = found(make_labelling(recording, names), sidecar)
        assert 0.3 < share <= 1
    assert json.loads(sidecar.read_text())["trajectories"]


def test_only_the_whole_reads_100_percent():
    assert [percent(x) for x in (1.0, 0.9999, 0.5, 0.29, 0.0)] == ["100.0%", "99.9%", "50.0%", "29.0%", "0.0%"]
