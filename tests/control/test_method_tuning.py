"""Every number of the full method says what it is, and is used."""

import re
from dataclasses import fields, replace
from pathlib import Path

import pytest

from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._numbers import numbers_of

PACKAGE = Path(__file__).resolve().parents[2] / "dshpm_jax"
SOURCES = {path: path.read_text() for path in PACKAGE.rglob("*.py") if path.name != "tuning.py"}


@pytest.mark.parametrize("number", list(numbers_of(TUNING)), ids=lambda number: number.name)
def test_a_number_names_a_module_that_is_there(number):
    modules = {path.stem for path in SOURCES} | {"_null_model"}
    used = re.split(r"[:,] ", number.used.split(":")[0])
    assert set(used) <= modules


@pytest.mark.parametrize("name", [one.name for one in fields(Tuning)])
def test_a_number_is_read_somewhere(name):
    """As a field, or by its name where a table of names is gone through."""
    assert any(re.search(rf'\b(tuning|null|TUNING)\.{name}\b|"{name}"', text) for text in SOURCES.values())


def test_a_tuning_is_a_key():
    """Prepared models and kernels are kept by it."""
    assert hash(Tuning()) == hash(TUNING) and replace(TUNING, patience=4) != TUNING
    assert hash(TUNING.null_model) != hash(replace(TUNING, t_dof=4.0).null_model)
