"""Pages as a browser shows them, and what they hold."""

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)

needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to show the page in")


def data_of(page: str) -> dict[str, Any]:
    """What a page's script works on."""
    (found,) = re.findall(r"^const DATA = (.*);$", page, re.MULTILINE)
    return json.loads(found)


class Elements(HTMLParser):
    """Every element and its attributes."""

    def __init__(self, page: str):
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))

    def count(self, tag: str) -> int:
        return sum(name == tag for name, _ in self.found)


def assert_self_contained(page: str) -> None:
    """One script, and nothing that a browser would fetch."""
    elements = Elements(page)
    assert elements.count("script") == 1
    assert not any(
        {"src", "href", "srcset", "onerror", "onload"} & attributes.keys() for _, attributes in elements.found
    )
    assert not re.search(r"@import|url\(|fetch\(|XMLHttp|import\(", page)


def shown(path: Path, profile: Path, fragment: str = "") -> str:
    """The page's elements after two seconds of its own time; a script that fails leaves the word FAILED.

    The browser skips time in which nothing is due but draws by the real clock, so that on a busy machine the two
    seconds can pass without a picture: here pictures come by the page's time too.
    """
    guard = (
        "<script>window.onerror = text => document.documentElement.append('FAI' + 'LED ' + text);"
        "window.requestAnimationFrame = draw => setTimeout(() => draw(performance.now()), 16)</script>"
    )
    copy = path.with_name(f"guarded-{path.name}")
    copy.write_text(path.read_text().replace("<head>", "<head>" + guard, 1))
    command = [
        str(CHROMIUM),
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={profile or path.parent}",
    ]
    command += ["--virtual-time-budget=2000", "--dump-dom", copy.as_uri() + fragment]
    return subprocess.run(command, capture_output=True, text=True, timeout=100, check=True).stdout
