"""The page in a real browser, by keyboard and by mouse: what is corrected there is in the files."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from browser import needs_browser
from devtools import Browser
from wrong_results import ARMS_EXCHANGED, take, write_wrong

from dshpm_jax import io
from dshpm_jax._corrections import corrections_path, read_corrections
from dshpm_jax._review.desk import Desk
from dshpm_jax._review.places import places_in
from dshpm_jax._review.serving import Server

pytestmark = needs_browser
pytest.importorskip("uvicorn", reason="the extra 'review' is not installed")


@pytest.fixture(scope="module")
def browser(tmp_path_factory) -> Iterator[Browser]:
    with Browser(tmp_path_factory.mktemp("profile")) as browser:
        yield browser


@contextmanager
def served(out: Path) -> Iterator[Server]:
    server = Server(Desk(places_in(out), out.name))
    server.start()
    try:
        yield server
    finally:
        server.stop()


def columns_named(out: Path, label: str) -> set[int]:
    """The columns of the recording that the result has under a label."""
    sidecar = io.read_sidecar(out / "walk.labels.json")
    assert sidecar is not None
    return {row["column"] for row in sidecar["trajectories"] if row["label"] == label}


def truth(label: str) -> set[int]:
    return {take()[1].index(label)}


def test_a_wrong_limb_is_mended_with_one_key(tmp_path, browser):
    out = write_wrong(tmp_path, ARMS_EXCHANGED)
    with served(out) as server:
        browser.open(server.address)
        assert "8 doubts" in browser.text("#left-over")
        browser.run("document.querySelector('.doubt b').innerText")
        for _ in range(8):
            if browser.text("#label-tab h2") == "RWRA":
                break
            browser.press("n")
        browser.wait_for_text("#label-tab .options", "LWRA")
        keys = browser.run("[...document.querySelectorAll('.option')].map(n => n.innerText)")
        key = next(text.split()[0] for text in keys if "LWRA" in text)
        browser.press(key)
        browser.wait_for_text("#label-tab", "also changes 7 other labels")
        assert read_corrections(corrections_path(out / "walk.c3d")) is None
        browser.press("Enter")
        browser.wait_for_text("#undo", "RWRA → LWRA")
        assert not browser.errors
    for label in ARMS_EXCHANGED:
        assert columns_named(out, label) == truth(label)
    assert "LWRA" in io.read(out / "walk.c3d").labels
    assert json.loads((out / "manifest.jsonl").read_text().splitlines()[-1])["output"] == "walk.c3d"
