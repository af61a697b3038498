"""What the package shows: its public names, its version and its types."""

import importlib
import re
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

import dshpm_jax

ROOT = Path(__file__).resolve().parents[1]


def test_dir_lists_the_public_names_alone():
    assert dir(dshpm_jax) == sorted(dshpm_jax.__all__) and len(set(dshpm_jax.__all__)) == len(dshpm_jax.__all__)
    assert [name for name in dshpm_jax.__all__ if name.startswith("_")] == ["__version__"]
    assert all(getattr(dshpm_jax, name) is not None for name in dshpm_jax.__all__)
    with pytest.raises(AttributeError, match="no attribute 'lable'"):
        dshpm_jax.lable  # pyright: ignore[reportAttributeAccessIssue]


def test_every_name_that_is_imported_for_others_is_public():
    imported = re.findall(r"import (\w+) as \1$", (ROOT / "dshpm_jax" / "__init__.py").read_text(), re.MULTILINE)
    assert sorted([*imported, "__version__"]) == sorted(dshpm_jax.__all__)


@pytest.mark.parametrize("room", ["io", "report", "evaluation", "synthesis"])
def test_rooms_are_there_without_an_import_of_their_own(room):
    assert getattr(dshpm_jax, room) is importlib.import_module(f"dshpm_jax.{room}")


def test_there_is_one_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    cited = re.search(r'^version: "(.+)"$', (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert cited and cited[1] == project["version"]
    assert dshpm_jax.__version__ == version("dshpm-jax")


def test_type_checkers_are_told_that_there_are_types():
    assert (ROOT / "dshpm_jax" / "py.typed").exists()
