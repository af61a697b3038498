"""Sizes that no body has, and sizes that some have."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from takes import model

from dshpm_jax import label, label_many
from dshpm_jax._size import extent, size_doubt
from dshpm_jax.synthesis import add_ghosts, person

WALK = person(34, "walking", 60, seed=3).recording


def scaled(factor):
    return replace(WALK, points=WALK.points * factor)


@pytest.mark.parametrize("factor", [0.001, 0.01, 0.1, 10.0, 100.0, 1000.0])
def test_a_wrong_unit_is_seen_beside_the_model(factor):
    assert "its points are spread over" in (size_doubt(scaled(factor), model()) or "")


@pytest.mark.parametrize("factor", [0.001, 1000.0])
def test_people_of_millimetres_and_kilometres_are_seen_without_a_model_and_with_one_of_their_own(factor):
    assert size_doubt(scaled(factor)) and size_doubt(scaled(factor), model().scaled(factor))


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_people_of_every_size_are_people(factor):
    assert size_doubt(scaled(factor), model()) == ""


def test_part_of_a_body_is_no_small_body():
    few = replace(WALK, points=np.where(np.arange(34)[:, None] < 4, WALK.points, np.nan))
    assert size_doubt(few, model()) == ""
    assert size_doubt(replace(WALK, points=WALK.points[:, :1], labels=("A",), columns=())) == ""


def test_size_does_not_depend_on_place_or_on_ghosts():
    moved = replace(WALK, points=WALK.points + (5000.0, -3000.0, 100.0))
    assert extent(moved) == pytest.approx(extent(WALK))
    spoilt = add_ghosts(WALK, 0.1, np.random.default_rng(0))
    assert extent(spoilt) == pytest.approx(extent(WALK), rel=0.3)


def test_labelling_warns_and_labels_nevertheless():
    with pytest.warns(UserWarning, match=r"over 1\.\d+ mm, those of the model .* probably m and not mm; .*points_unit"):
        assert len(label(scaled(0.001).frames(0, 10), model()).identity)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        label(WALK.frames(0, 10), model())
        next(label_many([scaled(0.001).frames(0, 10)], model()))  # whose caller looks at what came out
