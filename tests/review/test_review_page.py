"""The page in a real browser, by keyboard and by mouse: what is corrected there is in the files."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from browser import needs_browser
from devtools import Browser
from wrong_results import ARMS_EXCHANGED, take, write_wrong

from dshpm_jax import io
from dshpm_jax._archive import find_jobs
from dshpm_jax._corrections import corrections_path, read_corrections
from dshpm_jax._review.desk import Desk
from dshpm_jax._review.places import place_of, places_in
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


def hand(browser: Browser, label: str, frame: int | None = None) -> None:
    """Takes the trajectory with a label in hand, by its row of the timeline."""
    browser.press("Escape")
    for _ in range(60):
        if browser.text("#label-tab h2") == label:
            break
        browser.press("ArrowDown")
    assert browser.text("#label-tab h2") == label
    if frame is not None:
        go_to(browser, frame)


def go_to(browser: Browser, frame: int) -> None:
    browser.press("Home")
    for _ in range(frame // 10):
        browser.press("ArrowRight", shift=True)
    for _ in range(frame % 10):
        browser.press("ArrowRight")
    browser.wait_for_text("#time", f"frame {frame} of")


def test_a_cut_an_exchange_and_undo_after_a_reload(tmp_path, browser):
    out = write_wrong(tmp_path, {"LTOE": "RTOE", "RTOE": "LTOE"})
    with served(out) as server:
        browser.open(server.address)
        hand(browser, "C7", 40)
        browser.press("c")
        browser.wait_for_text("#undo", "cut C7 at frame 40")
        browser.wait_for_text("#extent-text", "Frames 40–119")
        hand(browser, "LTOE", 60)
        browser.press("x")
        browser.wait_for_text("#label-tab", "Exchange LTOE with")
        browser.click_on(".option", "RTOE")
        browser.wait(
            "document.querySelector('#undo').innerText.includes('LTOE') || document.querySelector('.main') !== null"
        )
        if browser.run("document.querySelector('.answers .main') !== null"):
            browser.press("Enter")
        browser.wait_for_text("#undo", "LTOE → RTOE, RTOE → LTOE")
        browser.wait_for_text("#saved", "written to the files")
        assert columns_named(out, "LTOE") == truth("LTOE") and columns_named(out, "RTOE") == truth("RTOE")
        browser.open(server.address)
        browser.wait_for_text("#undo", "LTOE → RTOE")
        browser.press("z")
        browser.wait_for_text("#undo", "cut C7")
        browser.press("z")
        browser.wait("document.querySelector('#undo').disabled")
        browser.press("y", "y")
        browser.wait("document.querySelector('#redo').disabled")
        browser.press("z")
        browser.wait_for_text("#undo", "cut C7")
        assert not browser.errors
    assert columns_named(out, "LTOE") == truth("RTOE")
    sidecar = io.read_sidecar(out / "walk.labels.json")
    assert sidecar is not None
    assert sorted(row["frames"] for row in sidecar["trajectories"] if row["label"] == "C7") == [[0, 39], [40, 119]]


def test_undo_after_the_program_was_started_again(tmp_path, browser):
    out = write_wrong(tmp_path, {"LTOE": "RTOE", "RTOE": "LTOE"})
    with served(out) as server:
        browser.open(server.address)
        hand(browser, "C7", 40)
        browser.press("c")
        browser.wait_for_text("#undo", "cut C7")
        browser.press("0")
        browser.wait("document.querySelector('.answers .main') !== null")  # the toes are mended as well
        browser.press("Escape")
    with served(out) as server:
        browser.open(server.address)
        while not browser.run("document.querySelector('#undo').disabled"):
            before = browser.text("#undo")
            browser.press("z")
            browser.wait(f"document.querySelector('#undo').innerText !== {json.dumps(before)}")
    sidecar = io.read_sidecar(out / "walk.labels.json")
    assert sidecar is not None
    assert [row["frames"] for row in sidecar["trajectories"] if row["label"] == "C7"] == [[0, 119]]


def test_a_still_is_named_from_nothing_by_clicking(tmp_path, browser):
    recording, names = take(4)
    source = tmp_path / "captures" / "still.c3d"
    source.parent.mkdir()
    io.write_c3d(recording, source)
    out = tmp_path / "named"
    jobs = find_jobs([source], [], out)
    places = {place.id: place for place in (place_of(out, replace(job, models=(), page=True)) for job in jobs)}
    server = Server(Desk(places, "named"))
    server.start()
    try:
        browser.open(server.address)
        browser.wait_for_text("#names-tab", "No names yet")
        browser.click_on("input[aria-label^='Add names']")
        wanted = ("C7", "LTOE", "RTOE", "SACR")
        browser.run(f"document.activeElement.value = '{' '.join(wanted)}'")
        browser.press("Enter")
        browser.wait("document.querySelectorAll('.names button').length === 4 && document.body.dataset.ready")
        for name in wanted:
            browser.wait_for_text(".names .now", name)
            browser.click(*place_on_screen(browser, recording.points[0, names.index(name)]))
            browser.wait_for_text("#undo", f"no label → {name}")
        browser.wait_for_text("#names-tab h2", "4 of 4")
        assert not browser.errors
    finally:
        server.stop()
    found = io.read(out / "still.c3d")
    assert found.labels[:4] == wanted
    for name in wanted:
        np.testing.assert_allclose(found[name], recording.points[:, names.index(name)], atol=1e-2)


def place_on_screen(browser: Browser, place: np.ndarray) -> tuple[float, float]:
    """Where a place in the room (mm) is on the page, by the camera that the page has."""
    return tuple(browser.run(f"window.reviewPlace({json.dumps(place.tolist())})"))


def test_by_mouse_alone(tmp_path, browser):
    out = write_wrong(tmp_path, {"LTOE": "RTOE", "RTOE": "LTOE"})
    with served(out) as server:
        browser.open(server.address)
        browser.click_on(".doubt", "LTOE")
        browser.wait_for_text("#label-tab h2", "LTOE")
        browser.wait_for_text("#label-tab .options", "LTOE")
        browser.click_on(".tools button", "Exchange with")
        browser.wait_for_text("#label-tab", "Exchange LTOE with")
        browser.click_on(".option", "RTOE")
        browser.wait_for_text("#undo", "LTOE → RTOE, RTOE → LTOE")
        browser.wait_for_text("#left-over", "nothing in doubt")
        browser.click_on("#undo")
        browser.wait_for_text("#left-over", "2 doubts")
        browser.click_on("#redo")
        browser.wait_for_text("#left-over", "nothing in doubt")
        browser.click_on("#tabs button", "Done")
        browser.wait_for_text("#done-tab", "LTOE → RTOE")
        browser.click_on("#tabs button", "Gaps")
        browser.wait("document.querySelector('#gaps-tab h2') !== null")
        assert not browser.errors
    assert columns_named(out, "LTOE") == truth("LTOE") and columns_named(out, "RTOE") == truth("RTOE")


def test_a_part_of_a_trajectory(tmp_path, browser):
    out = write_wrong(tmp_path, {})
    with served(out) as server:
        browser.open(server.address)
        hand(browser, "C7", 60)
        browser.press(".")
        browser.wait_for_text("#extent-text", "Frames 60–119")
        browser.press(",")
        browser.wait_for_text("#extent-text", "Frames 0–60")
        browser.press("i")
        go_to(browser, 80)
        browser.press("o")
        browser.wait_for_text("#extent-text", "Frames 60–80")
        browser.press("0")
        browser.wait_for_text("#undo", "C7 → no marker, frames 60–80")
        assert not browser.errors
    sidecar = io.read_sidecar(out / "walk.labels.json")
    assert sidecar is not None
    assert sorted(row["frames"] for row in sidecar["trajectories"] if row["label"] == "C7") == [[0, 59], [81, 119]]
