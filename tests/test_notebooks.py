"""The notebooks run, on takes of two seconds, hold no output, and use public names only."""

import json
import re
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb"))
SHORT = "FRAMES = 120"

each_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def code_cells(path: Path) -> list[dict]:
    return [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]


@each_notebook
def test_code_cells_run(path, tmp_path, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    monkeypatch.setattr("tempfile.mkdtemp", lambda: str(tmp_path))
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    names: dict = {"__name__": "__main__"}
    for cell in code_cells(path):
        source = re.sub(r"FRAMES = \d+", SHORT, "".join(cell["source"]))
        exec(compile(source, path.name, "exec"), names)
    if "total" in names:
        assert names["total"].precision > 0.95 and names["total"].recall > 0.8


@each_notebook
def test_no_output_is_kept(path):
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code_cells(path))


@each_notebook
def test_names_are_public(path):
    source = "\n".join("".join(cell["source"]) for cell in code_cells(path))
    assert not re.findall(r"dshpm_jax(?:\.\w+)*\._\w+|from dshpm_jax\S* import _\w+", source)


def test_there_are_notebooks():
    assert NOTEBOOKS
