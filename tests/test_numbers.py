"""Chosen numbers say their unit, use, evidence and group."""

from dataclasses import FrozenInstanceError, dataclass, replace

import pytest

from dshpm_jax._numbers import number, numbers_of

KNOWN = {"unit": "mm", "used": "the fit: if a residual > this, it is cut", "evidence": "by hand", "group": "fitting"}


@dataclass(frozen=True)
class Tuning:
    reach: float = number(4.0, **KNOWN)
    factors: tuple[float, float] = number((1.0, 2.0), **KNOWN | {"unit": "factor"})


def test_a_tuning_has_its_defaults_and_stays_frozen():
    tuning = Tuning()
    assert (tuning.reach, tuning.factors) == (4.0, (1.0, 2.0)) and replace(tuning, reach=5.0).reach == 5.0
    with pytest.raises(FrozenInstanceError):
        tuning.reach = 3.0  # pyright: ignore[reportAttributeAccessIssue]


def test_every_number_says_what_is_known_of_it():
    reach, factors = numbers_of(Tuning)
    assert (reach.name, reach.default, reach.unit, reach.group) == ("reach", 4.0, "mm", "fitting")
    assert str(reach) == "mm; used in the fit: if a residual > this, it is cut; by hand"
    assert factors.default == (1.0, 2.0) and list(numbers_of(Tuning())) == [reach, factors]


@pytest.mark.parametrize("text", KNOWN)
def test_an_empty_text_is_refused(text):
    with pytest.raises(ValueError, match=f"4.0 says nothing of its {text}"):
        number(4.0, **KNOWN | {text: " "})
