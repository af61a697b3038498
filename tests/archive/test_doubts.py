"""What makes labels doubtful."""

from dataclasses import replace

import numpy as np
import pytest

from dshpm_jax import Labelling, Reason, SubjectModel
from dshpm_jax._archive.doubts import all_doubts, doubts_of
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH
from dshpm_jax.synthesis import person

TAKE = person(34, "walking", 60, 60.0, seed=1).recording
MODEL = SubjectModel.from_recordings([TAKE])


def unlabelled(factor: float, columns=slice(None), unit: str = "mm", **stats) -> Labelling:
    points = np.array(TAKE.points[:, columns]) * factor
    recording = replace(TAKE, points=points, labels=tuple("" for _ in range(points.shape[1])), columns=(), unit=unit)
    tracks = from_columns(points, TAKE.rate)
    none = np.full(len(tracks), NO_MATCH)
    return Labelling(recording, MODEL, tracks, none, np.ones(len(none)), (Reason.OUTSIDE,) * len(none), stats)


@pytest.mark.parametrize(
    ("factor", "unit", "right"),
    [(0.001, "mm", "m"), (0.1, "mm", "cm"), (1 / 25.4, "mm", "in"), (1000, "m", "mm"), (100, "m", "cm")],
)
def test_a_unit_that_is_off_is_named(factor, unit, right):
    (found,) = doubts_of(unlabelled(factor, unit=unit), completeness=0.0)
    assert found.endswith(f"so its unit is probably {right} and not {unit}")


def test_a_person_1_8_mm_tall():
    (found,) = doubts_of(unlabelled(0.001), completeness=0.0)
    assert found.startswith("its points are spread over 1.") and " mm, those of the model over 1." in found


def test_sizes_that_a_unit_does_not_explain_are_no_doubt_of_it():
    assert not doubts_of(unlabelled(1.0), 0.0) and not doubts_of(unlabelled(1.4), 0.0)
    assert not doubts_of(unlabelled(1.0, columns=slice(0, 1)), 0.0)  # one point has no size
    assert not doubts_of(unlabelled(0.1), completeness=0.9)  # the labels fit, so a part of the body is seen
    assert not doubts_of(unlabelled(0.1, model_fit=1.0), completeness=0.9)
    assert doubts_of(unlabelled(0.1, model_fit=0.1), completeness=0.9)


def test_reasons_that_the_labelling_gives_itself():
    assert doubts_of(unlabelled(1.0, doubts=["its axes are mirrored"]), 1.0) == ["its axes are mirrored"]


def test_evidence():
    poor = {"model_fit": TUNING.poor_fit_below - 0.11, "labelled_points": 9, "doubts": ["its axes are mirrored"]}
    assert all_doubts(poor) == ("its axes are mirrored", "its labels hold only 69% of the usual evidence")
    assert all_doubts(poor | {"labelled_points": 0}) == ("its axes are mirrored",)
    assert all_doubts(poor | {"labelled_points": 0, "doubts": []}) == ("none of its points fits the model",)
    assert all_doubts(poor | {"model_fit": TUNING.poor_fit_below}) == ("its axes are mirrored",)
    assert all_doubts({"model_fit": None, "labelled_points": 9}) == ()
