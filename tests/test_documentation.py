"""Every public name says what it is: what comes in, in which unit, and what can go wrong."""

import importlib
import inspect

import pytest

MODULES = ("dshpm_jax", "dshpm_jax.io", "dshpm_jax.synthesis", "dshpm_jax.evaluation", "dshpm_jax.report")
SMALL = 12  # lines of source that one line can say all about
SELF_EVIDENT = {"self", "path", "recording", "recordings", "labelling", "model", "motion"}


def public(module: str) -> list:
    home = importlib.import_module(module)
    names = [name for name in dir(home) if not name.startswith("_")]
    found = [getattr(home, name) for name in names]
    return [
        pytest.param(thing, id=f"{module}.{name}")
        for name, thing in zip(names, found)
        if (inspect.isclass(thing) or inspect.isfunction(thing)) and thing.__module__.startswith("dshpm_jax")
    ]


each_name = pytest.mark.parametrize("thing", [one for module in MODULES for one in public(module)])


@each_name
def test_it_has_a_docstring_that_is_more_than_a_line_unless_it_is_small(thing):
    lines = (inspect.getdoc(thing) or "").splitlines()
    assert lines and lines[0].strip()
    assert len(lines) > 1 or len(inspect.getsource(thing).splitlines()) <= SMALL


@each_name
def test_it_names_its_arguments_or_fields(thing):
    text = inspect.getdoc(thing) or ""
    if inspect.isfunction(thing):
        names = set(inspect.signature(thing).parameters)
    else:
        names = set(getattr(thing, "__dataclass_fields__", ()) or getattr(thing, "_fields", ()))
    unsaid = {name for name in names - SELF_EVIDENT if not name.startswith("_") and name not in text}
    assert not unsaid


def test_there_are_names_to_look_at():
    assert len(public("dshpm_jax")) > 30 and len(public("dshpm_jax.io")) > 5
