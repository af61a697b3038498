"""The README names what is there: its table, its Python and its TOML."""

import ast
import importlib
import re
import tomllib
from pathlib import Path

import pytest

import dshpm_jax
from dshpm_jax import Settings

README = (Path(__file__).resolve().parents[1] / "README.md").read_text()
PLACES = re.findall(r"`([\w/]+):(\w+)`", README)


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize("place", PLACES, ids=":".join)
def test_code_of_the_paper_is_where_it_says(place):
    module, name = place
    assert hasattr(importlib.import_module(f"dshpm_jax.{module.replace('/', '.')}"), name)


@pytest.mark.parametrize("text", blocks("python"))
def test_python_uses_public_names(text):
    imports = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)]
    names = [alias.name for node in imports if node.module == "dshpm_jax" for alias in node.names]
    assert names and all(hasattr(dshpm_jax, name) for name in names)


def test_toml_is_understood(tmp_path):
    segments, settings = blocks("toml")
    (tmp_path / "settings.toml").write_text(settings)
    Settings.from_toml(tmp_path / "settings.toml")
    known = tomllib.loads(segments)
    assert all(entry.get("parent", "pelvis") in known for entry in known.values())
