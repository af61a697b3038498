"""Imports never go upwards, and what must start fast does not import jax."""

import ast
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "dshpm_jax"

LEVELS = [
    {"_messages", "_types", "_console", "_compile_cache"},
    {"_recording", "_trajectories", "_hierarchy", "_settings", "_model_building"},
    {"_model", "_scoring", "_subjects"},
    {"_labelling", "_requests"},
    {"_kernels", "io", "synthesis"},
    {"_driver", "_control", "_pretracking", "_reading"},
    {"_label", "_live", "_check"},
    {"evaluation", "report", "_reconstruction"},
    {"_archive", "_checking", "_demo", "_experiments", "_reconstructing", "_viewing"},
    {"__main__", "__init__"},
]
LEVEL = {name: k for k, names in enumerate(LEVELS) for name in names}


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module} if node.module != "dshpm_jax" else {f"dshpm_jax.{a.name}" for a in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name.split(".")[1] for name in found if name.startswith("dshpm_jax.")} & LEVEL.keys()


def room(path: Path) -> str:
    parts = path.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else path.stem


def test_every_file_has_a_level():
    assert {room(p) for p in PACKAGE.rglob("*.py")} <= LEVEL.keys()


def test_imports_never_go_upwards():
    upwards = [
        f"{path.relative_to(PACKAGE)} imports {name}"
        for path in PACKAGE.rglob("*.py")
        for name in imports(path)
        if LEVEL[name] > LEVEL[room(path)]
    ]
    assert not upwards


def test_importing_the_package_leaves_jax_out():
    code = "import sys, dshpm_jax, dshpm_jax.io; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_labelling_starts_without_optimistix():
    code = "import sys, dshpm_jax._label; sys.exit('jax' not in sys.modules or 'optimistix' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
