"""The option `--open`, of commands that write pages."""

import webbrowser
from pathlib import Path
from typing import Any

from dshpm_jax._console import complain
from dshpm_jax.report._page_name import PAGE_NAME


def add_open(options: Any, what: str) -> None:
    """The option itself; `what` says which page."""
    options.add_argument("--open", action="store_true", help=f"show {what} in the browser")


def open_page(page: Path) -> None:
    """Shows a page, that of a run if `page` is the folder of its results; a machine without a browser does no harm."""
    page = page / PAGE_NAME if page.is_dir() else page
    if page.is_file() and not webbrowser.open(page.resolve().as_uri()):
        complain(f"{page}: found no browser to open it in; open it yourself")
