"""The labeller gives what it gave: labels and reasons of some synthetic takes, confidences and figures beside them.

A change that is meant to alter labels makes the files anew with `make.py`, which says when.
"""

import pytest
from golden_takes import CASES, FOLDER, kept, labelled

CLOSE = 1e-3
FITS = 0.03  # share by which the number of rigid fits may differ

each = pytest.mark.parametrize("name", CASES)


def rows(found: dict, *keys: str) -> list[tuple]:
    return [tuple(row[key] for key in keys) for row in found["trajectories"]]


@each
def test_labels(name):
    assert rows(labelled(name), "frames", "label") == rows(kept(name), "frames", "label")


@each
def test_reasons(name):
    assert rows(labelled(name), "frames", "reason") == rows(kept(name), "frames", "reason")


@each
def test_confidences(name):
    now, before = ([row["confidence"] for row in found["trajectories"]] for found in (labelled(name), kept(name)))
    assert now == pytest.approx(before, abs=CLOSE)


@each
def test_model_fit(name):
    now, before = (found["figures"].get("model_fit") for found in (labelled(name), kept(name)))
    assert now == pytest.approx(before, abs=CLOSE)


@each
def test_rigid_fits(name):
    now, before = (found["figures"]["svd_count"] for found in (labelled(name), kept(name)))
    assert now == pytest.approx(before, rel=FITS)


def test_every_file_is_of_a_take():
    assert sorted(path.stem for path in FOLDER.glob("*.json")) == sorted(CASES)
