"""The page itself: its frame, style and script, put together from the player's parts and its own."""

from functools import cache
from importlib.metadata import version
from importlib.resources import files

from dshpm_jax.report._page import GENERATOR

OWN = "dshpm_jax._review"
PLAYER = "dshpm_jax.report"

BEFORE = ("words", "calls", "queue")
"""Scripts that run before a trial is there."""

WITH_TRIAL = (
    *("page/recording", "player/camera", "player/gaps", "player/names", "player/figure", "player/timeline"),
    *("player/time", "page/trail", "page/extent", "page/candidates", "page/proposal", "page/tools", "page/listing"),
    *("page/filling", "page/walk", "player/mouse", "page/keys", "page/begin"),
)
"""Scripts that run when its data is, in this order; those of the player are its own."""


@cache
def frame() -> bytes:
    """The page, which loads nothing but its own style and script."""
    head = f'{GENERATOR} {version("dshpm-jax")}">'
    return _text(OWN, "page/frame.html").replace("%%GENERATOR%%", head).encode()


@cache
def style() -> bytes:
    """That of all pages, of the player, and the page's own."""
    texts = (_text(PLAYER, "page.css"), _text(PLAYER, "player/style.css"), _text(OWN, "page/style.css"))
    return "\n".join(texts).encode()


@cache
def script() -> bytes:
    """One function that runs when the trial's data is there."""
    before = [_text(OWN, f"page/{name}.js") for name in BEFORE]
    parts = [_text(PLAYER if name.startswith("player/") else OWN, f"{name}.js") for name in WITH_TRIAL]
    whole = ['"use strict";', *before, "async function run(DATA, QUEUE) {", *parts, "}", "start();"]
    return "\n".join(whole).encode()


def _text(package: str, name: str) -> str:
    return (files(package) / name).read_text(encoding="utf-8")
