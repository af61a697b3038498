"""`check` finds planted errors and leaves sound labels in peace."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from takes import model

from dshpm_jax import Finding, Recording, SubjectModel, check, read
from dshpm_jax._control.tuning import TUNING
from dshpm_jax.synthesis import person

SOUND = person(34, frames=90, seed=110).recording


def exchanged(recording: Recording, one: str, other: str, frames: slice) -> Recording:
    points = recording.points.copy()
    a, b = recording.labels.index(one), recording.labels.index(other)
    points[frames, a], points[frames, b] = recording.points[frames, b], recording.points[frames, a]
    return replace(recording, points=points)


def said(findings: list[Finding]) -> list[tuple]:
    return [(f.label, f.first, f.last, f.should_be) for f in findings]


def test_sound_labels_are_left_in_peace():
    assert check(SOUND, model()) == []


@pytest.mark.parametrize("frames", [(0, 89), (30, 59), (40, 40)], ids=str)
def test_exchanged_labels(frames):
    first, last = frames
    found = check(exchanged(SOUND, "LKNE", "LTIB", slice(first, last + 1)), model())
    assert sorted(said(found)) == [("LKNE", first, last, "LTIB"), ("LTIB", first, last, "LKNE")]
    assert all(f.evidence > TUNING.decisive_llr for f in found)


def test_sides_of_the_whole_body_exchanged():
    """Nothing near a marker tells; the labels agree with each other everywhere."""
    mirrored = {"L": "R", "R": "L"}
    labels = tuple(mirrored.get(name[0], name[0]) + name[1:] for name in SOUND.labels)
    wrong = replace(SOUND, labels=labels)
    assert {f.should_be for f in check(wrong, model())} >= {"LKNE", "RKNE", "LTOE", "RTOE"}


def test_a_label_that_goes_over_to_a_ghost_and_a_marker_without_a_name():
    points = SOUND.points.copy()
    column = SOUND.labels.index("RANK")
    left = np.full((len(points), 1, 3), np.nan)
    left[40:, 0] = points[40:, column]
    points[40:, column] += 400.0
    wrong = Recording(np.concatenate([points, left], axis=1), (*SOUND.labels, "*1"), SOUND.rate)
    assert said(check(wrong, model())) == [("RANK", 40, 89, None), ("*1", 40, 89, "RANK")]


def test_a_point_that_leaps_off_its_place():
    points = SOUND.points.copy()
    points[50:52, SOUND.labels.index("LFHD")] += (0.0, 0.0, 70.0)
    assert said(check(replace(SOUND, points=points), model())) == [("LFHD", 50, 51, None)]


def test_labels_of_nobody_are_refused():
    with pytest.raises(ValueError, match="none of its labels is in the model"):
        check(replace(SOUND, labels=tuple(f"M{k}x" for k in range(34))), model())


def test_known_errors_of_a_real_recording(data):
    def markers(name: str) -> Recording:
        """Without the hip centres that were computed."""
        recording = read(data / "opencap-s4-47" / name)
        kept = [k for k, label in enumerate(recording.labels) if "HJC" not in label]
        return Recording(recording.points[:, kept], tuple(recording.labels[k] for k in kept), recording.rate)

    known = SubjectModel.from_recordings([markers("walking4.trc").frames(14), markers("DJ1.trc")])
    found = check(markers("walking1.trc"), known)
    assert said(found) == [("r_thigh3", 10, 10, "r_thigh5"), ("r_thigh5", 7, 7, "r_thigh3")]
    assert check(markers("DJ2.trc").frames(0, 130), known) == []


def test_importing_check_alone_leaves_jax_out():
    code = "import sys, dshpm_jax; 'check' in dir(dshpm_jax); sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_a_model_that_cannot_judge_is_refused():
    with pytest.raises(ValueError, match="no neighbourhoods"):
        check(SOUND, replace(model(), neighbourhoods=()))
