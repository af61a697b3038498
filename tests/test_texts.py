"""Texts are true: their blocks run, their links lead somewhere, their tables name what is there; and they are short."""

import ast
import importlib
import os
import re
import shlex
import subprocess
import sys
import tomllib
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import pytest

import dshpm_jax
from dshpm_jax import Settings
from dshpm_jax.__main__ import _parser
from dshpm_jax._compile_cache import cache_folder

HOME = Path(__file__).resolve().parents[1]
README = HOME / "README.md"
GUIDES = sorted((HOME / "notebooks" / "guides").glob("*.md"))
TEXTS = [
    README,
    *GUIDES,
    HOME / "dshpm_jax" / "README.md",
    HOME / "dshpm_jax" / "_control" / "README.md",
    HOME / "bench" / "README.md",
    HOME / ".github" / "CONTRIBUTING.md",
]
README_LINES = 150
SENTENCE_WORDS = 40
SECONDS = 300  # of one block, on a slow machine
FENCE = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s]+)\)")
PLACE = re.compile(r"`([\w/]+):(\w+)`")


class Block(NamedTuple):
    """A fenced block: its language, what else its first line says, its text."""

    language: str
    more: str
    text: str


def blocks(path: Path) -> list[Block]:
    return [Block(language, more.strip(), text) for language, more, text in FENCE.findall(path.read_text())]


def name_of(path: Path) -> str:
    return path.relative_to(HOME).as_posix()


each_text = pytest.mark.parametrize("path", TEXTS, ids=name_of)
each_guide = pytest.mark.parametrize("path", [README, *GUIDES], ids=name_of)


@pytest.fixture(scope="session")
def environment(tmp_path_factory):
    """The environment of the blocks: this interpreter's `dshpm-jax`, and one folder of compiled programs for all."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DSHPM_CACHE", os.environ.get("DSHPM_CACHE") or str(tmp_path_factory.mktemp("programs")))
        patch.setenv("JAX_COMPILATION_CACHE_DIR", str(cache_folder()))  # what Python blocks go by
        patch.setenv("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
        patch.setenv("PATH", os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")]))
        patch.setenv("MPLBACKEND", "Agg")
        return dict(os.environ)


@each_guide
def test_blocks_run_in_order(path, tmp_path, environment):
    """Shell in order, then all Python as one program; a block of text is part of what the block before it printed."""
    said, of_program = "", []
    for before, block in pairwise([Block("", "", ""), *blocks(path)]):
        if block.language == "sh":
            status, said = run(["bash", "-uo", "pipefail", "-c", block.text], tmp_path, environment)
            assert status == int(block.more.removeprefix("status=") or 0), f"{block.text}{said}"
        elif block.language == "text" and before.language == "python":
            of_program += block.text.splitlines()
        elif block.language == "text":
            assert_said(block.text.splitlines(), said)
        elif block.language == "toml":
            (tmp_path / write_name(block)).write_text(block.text)
    program = "\n".join(block.text for block in blocks(path) if block.language == "python" and not block.more)
    (tmp_path / "program.py").write_text(program)
    status, said = run([sys.executable, "-W", "error", "program.py"], tmp_path, environment) if program else (0, "")
    assert status == 0, said
    assert_said(of_program, said)


def assert_said(lines: list[str], said: str) -> None:
    assert not (lacking := [line for line in lines if line not in said]), (lacking, said)


def run(command: list[str], folder: Path, environment: dict[str, str]) -> tuple[int, str]:
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=SECONDS)
    return done.returncode, done.stdout + done.stderr


def write_name(block: Block) -> str:
    """The file that a TOML block stands for: segments have markers, anything else is settings."""
    is_segments = all(isinstance(value, dict) for value in tomllib.loads(block.text).values())
    return "segments.toml" if is_segments else "settings.toml"


@each_text
def test_toml_is_understood(path, tmp_path):
    for block in blocks(path):
        if block.language != "toml":
            continue
        if write_name(block) == "settings.toml":
            (tmp_path / "settings.toml").write_text(block.text)
            Settings.from_toml(tmp_path / "settings.toml")
        else:
            known = tomllib.loads(block.text)
            assert all(entry.get("parent", next(iter(known))) in known for entry in known.values())


@each_text
def test_commands_and_their_options_are_known(path):
    for block in blocks(path):
        if block.language in ("sh", "console"):
            for command in commands(block.text):
                _parser().parse_args(command)


def commands(text: str) -> list[list[str]]:
    """The arguments of every `dshpm-jax` in a block, with a stand-in for what the shell would fill in."""
    lines = re.sub(r"\\\n", " ", text).replace("$SLURM_ARRAY_TASK_ID/32", "0/32").splitlines()
    parts = [part for line in lines for part in re.split(r"&&|;|'", line)]
    return [shlex.split(part)[1:] for part in parts if part.strip().startswith("dshpm-jax")]


@each_text
def test_python_uses_public_names(path):
    for block in blocks(path):
        if block.language == "python":
            imports = [node for node in ast.walk(ast.parse(block.text)) if isinstance(node, ast.ImportFrom)]
            ours = [node for node in imports if (node.module or "").startswith("dshpm_jax")]
            assert not [node.module for node in ours if "._" in str(node.module)]
            names = [alias.name for node in ours if node.module == "dshpm_jax" for alias in node.names]
            assert all(hasattr(dshpm_jax, name) for name in names)


def test_blocks_are_of_a_kind_that_is_tested():
    kinds = {"sh", "console", "text", "toml", "python"}
    assert not [(name_of(path), b.language) for path in TEXTS for b in blocks(path) if b.language not in kinds]


@pytest.mark.parametrize("place", sorted({p for path in TEXTS for p in PLACE.findall(path.read_text())}), ids=":".join)
def test_code_is_where_it_says(place):
    module, name = place
    assert hasattr(importlib.import_module(f"dshpm_jax.{module.replace('/', '.')}"), name)


@each_text
def test_links_lead_somewhere(path):
    links = [link for link in LINK.findall(path.read_text()) if "://" not in link]
    assert not [link for link in links if not leads_somewhere(path, link)]


def leads_somewhere(path: Path, link: str) -> bool:
    file, _, anchor = link.partition("#")
    target = path.parent / file if file else path
    return target.exists() and (not anchor or anchor in anchors(target))


def anchors(path: Path) -> set[str]:
    """The anchors that GitHub gives the headings of a text."""
    headings = re.findall(r"^#+ (.*)$", path.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_the_readme_is_short():
    assert len(README.read_text().splitlines()) <= README_LINES


def test_the_readme_has_no_figures_before_the_first_command():
    before = README.read_text().split("```")[0]
    assert not re.findall(r"\d", re.sub(r"3-D|Python 3\.\d+|\[[^]]*\]\([^)]*\)", "", before))


def test_the_picture_is_small():
    assert (HOME / "notebooks" / "guides" / "demo.png").stat().st_size <= 150_000


@each_text
def test_sentences_are_short(path):
    assert not [s for s in sentences(path.read_text()) if len(s.split()) > SENTENCE_WORDS]


def sentences(text: str) -> list[str]:
    """Sentences of running text and of cells of tables, roughly; code and addresses of links are left out."""
    text = LINK.sub("]", FENCE.sub("", text))
    text = re.sub(r"^    .*$", "", text, flags=re.MULTILINE)  # what is indented is code
    text = re.sub(r"^(\s*(?:[-*]|\d+\.) |#+ )", r"\n\n\1", text, flags=re.MULTILINE)  # items and headings end others
    paragraphs = [part for block in re.split(r"\n\s*\n", text) for part in re.split(r"\s*\|\s*", block)]
    return [" ".join(s.split()) for part in paragraphs for s in re.split(r"(?<=[.!?])\s+", part)]


def test_long_sentences_are_found():
    assert sentences("- One two. Three\nfour five.\n- Six")[-3:] == ["- One two.", "Three four five.", "- Six"]
    assert max(len(s.split()) for s in sentences("word " * 41 + "end. Short one.")) == 42


def test_every_bench_has_a_row():
    rows = set(re.findall(r"^\| `(\w+\.py)", (HOME / "bench" / "README.md").read_text(), re.MULTILINE))
    scripts = {path.name for path in (HOME / "bench").glob("*.py") if not path.name.startswith("_")}
    assert rows == scripts


@each_text
def test_scripts_are_there(path):
    named = re.findall(r"python ((?:bench|tests)/[\w/]+\.py)", path.read_text())
    assert not [name for name in named if not (HOME / name).is_file()]
