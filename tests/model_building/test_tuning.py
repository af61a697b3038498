"""Every number of model making is used, says what it is for, and reaches the model."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

import dshpm_jax._model_building
from dshpm_jax._model_building import TUNING, model_from_recordings
from dshpm_jax._numbers import numbers_of
from dshpm_jax.synthesis import person

FOLDER = Path(dshpm_jax._model_building.__file__).parent
EVIDENCE = re.compile(r"paper|by hand(: .+)?|(derived|fitted): .+", re.DOTALL)


@pytest.mark.parametrize("number", list(numbers_of(TUNING)), ids=lambda number: number.name)
def test_a_number_is_used_where_it_says_so(number):
    sources = {path.name: path.read_text() for path in FOLDER.glob("*.py")}
    assert any(f"tuning.{number.name}" in source for source in sources.values())
    where = number.used.split(":")[0].split(", ")
    assert all(any(f"def {name}(" in source for source in sources.values()) for name in where)
    assert EVIDENCE.fullmatch(number.evidence) and number.default == getattr(TUNING, number.name)


@pytest.mark.parametrize("name", ["max_frames", "general_mm", "min_marker_sd_mm", "ratio_high", "shape_frames"])
def test_a_moved_number_makes_another_model(name):
    recordings = [person(34, frames=120, seed=1).recording]
    moved = dataclasses.replace(TUNING, **{name: type(getattr(TUNING, name))(getattr(TUNING, name) * 0.05)})
    usual, other = (model_from_recordings(recordings, tuning=tuning) for tuning in (TUNING, moved))
    assert any(
        not np.array_equal(a, b, equal_nan=True) for a, b in zip(_lengths(usual), _lengths(other), strict=True)
    ) or [s.markers for s in usual.segments] != [s.markers for s in other.segments]


def _lengths(model) -> list:
    ratios = np.array([segment.distortion_ratio for segment in model.segments])
    shapes = np.sort(np.concatenate([segment.shape.ravel() for segment in model.segments]))
    sds = np.array([near.marker_sd for near in model.neighbourhoods])
    return [model.pair_mean, model.pair_spread, ratios, shapes, sds]
