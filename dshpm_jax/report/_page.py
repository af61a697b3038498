"""Self-contained pages: one HTML file with its style, script and data inside, which loads nothing from anywhere."""

import html
import json
from collections.abc import Mapping
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

from dshpm_jax.io import WriteError
from dshpm_jax.io._atomic import write_whole

GENERATOR = '<meta name="generator" content="dshpm-jax'
HEAD_BYTES = 1000  # of a file, in which the generator stands if the page is ours

SCRIPTS = {
    "run": ("words", "table", "trials", "others"),
    "player": (
        "recording",
        "camera",
        "gaps",
        "names",
        "figure",
        "timeline",
        "doubts",
        "time",
        "mouse",
        "hands",
        "begin",
    ),
}
"""The scripts of each kind of page, in its folder, in the order in which they run."""


def make_page(kind: str, title: str, data: Mapping[str, Any], *more: str) -> str:
    """The page `kind` (a folder of parts beside this file) over `data`, which its scripts find as `DATA`.

    Scripts named in `more` run after its own. Names go into the page as JSON and from there as text, never as HTML, so
    they may hold anything.
    """
    filled = {
        "GENERATOR": f'{GENERATOR} {version("dshpm-jax")}">',
        "TITLE": html.escape(title),
        "STYLE": _part("page.css") + _part(f"{kind}/style.css"),
        "BODY": _part(f"{kind}/body.html"),
        "DATA": _script_safe(data),
        "SCRIPT": "\n".join(_part(f"{kind}/{name}.js") for name in (*SCRIPTS[kind], *more)),
    }
    pieces = _part("page.html").split("%%")  # text, name, text, name, ..., so that nothing filled in is filled again
    return "".join(filled[piece] if k % 2 else piece for k, piece in enumerate(pieces))


def write_page(page: str, path: Path) -> None:
    """Writes a page; one of ours that is there gives way, anything else does not (`WriteError`)."""
    if path.exists() and not is_page(path):
        raise WriteError(path, "is there and no page of ours, not overwritten", "move it away")
    try:
        write_whole(path, [page.encode(errors="replace")])
    except OSError as error:
        raise WriteError(path, f"cannot be written ({error.strerror})", "give another file") from None


def is_page(path: Path) -> bool:
    """Whether a file is a page that we wrote."""
    try:
        with path.open("rb") as file:
            return GENERATOR.encode() in file.read(HEAD_BYTES)
    except OSError:
        return False


def _part(name: str) -> str:
    return (files("dshpm_jax.report") / name).read_text(encoding="utf-8")


def _script_safe(data: Mapping[str, Any]) -> str:
    """JSON in which no name can end the script element that holds it."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
