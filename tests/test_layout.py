"""Imports never go upwards, and what must start fast does not import jax."""

import ast
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "dshpm_jax"

LEVELS = [
    {
        "_messages",
        "_types",
        "_console",
        "_compile_cache",
        "_processes",
        "_numbers",
        "_null_model",
        "_buckets",
        "_geometry",
        "_outcomes",
    },
    {"_recording", "_known", "_bridges", "_trajectories", "_columns", "_settings"},
    {"_model", "_hierarchy"},
    {"_model_building", "_scoring", "_subjects", "_marker_set"},
    {"_labelling", "_requests"},
    {"_kernels", "io", "synthesis", "_given", "_size", "_corrections"},
    {"_driver", "_control", "_pretracking", "_reading"},
    {"_label", "_correct", "_live", "_check", "_unseen"},
    {"evaluation", "report", "_reconstruction"},
    {"_archive", "_demo", "_experiments", "_model_choice"},
    {"_review"},
    {"_commands"},
    {"__main__", "__init__"},
]
LEVEL = {name: k for k, names in enumerate(LEVELS) for name in names}


# `SubjectModel.from_recordings` and its kin are how people make a model, so they stand on the class: each calls a maker
# that it imports when it is called. The recordings may be given as files, which `_given` reads.
WHEN_CALLED = {
    "_model.py imports _model_building",
    "_model.py imports _given",
    "_marker_set/marker_set.py imports _given",
}


def imports(path: Path, when_called: bool = True) -> set[str]:
    """Rooms that a file imports from, also inside functions (`when_called`) and for annotations."""
    found: set[str] = set()
    waiting: list[ast.AST] = [ast.parse(path.read_text())]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module} if node.module != "dshpm_jax" else {f"dshpm_jax.{a.name}" for a in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif when_called or not (isinstance(node, ast.FunctionDef) or _for_annotations(node)):
            waiting += ast.iter_child_nodes(node)
    return {name.split(".")[1] for name in found if name.startswith("dshpm_jax.")} & LEVEL.keys()


def _for_annotations(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def room(path: Path) -> str:
    parts = path.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else path.stem


def upwards(when_called: bool) -> set[str]:
    return {
        f"{path.relative_to(PACKAGE)} imports {name}"
        for path in PACKAGE.rglob("*.py")
        for name in imports(path, when_called)
        if LEVEL[name] > LEVEL[room(path)]
    }


def test_every_file_has_a_level():
    assert {room(p) for p in PACKAGE.rglob("*.py")} <= LEVEL.keys()


def test_imports_never_go_upwards():
    assert upwards(when_called=False) == set()


def test_imports_inside_functions_go_upwards_only_from_the_constructors_of_models():
    assert upwards(when_called=True) == WHEN_CALLED


def test_importing_the_package_leaves_jax_out():
    code = "import sys, dshpm_jax, dshpm_jax.io; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_commands_start_without_the_slow_parts_of_scipy():
    """They take half of a second, which `--help`, models and most files need not wait for."""
    slow = {"scipy.optimize", "scipy.spatial"}
    code = f"import sys, dshpm_jax.__main__; sys.exit(bool({slow} & sys.modules.keys()))"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_control_imports_no_jax():
    rooms = ("methods", "uses.audit", "uses.incremental", "uses.population")
    imports = "; ".join(f"import dshpm_jax._control.{room}" for room in rooms)
    code = f"import sys; {imports}; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_labelling_starts_without_optimistix():
    code = "import sys, dshpm_jax._label; sys.exit('jax' not in sys.modules or 'optimistix' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
