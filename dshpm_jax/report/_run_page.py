"""`report.html` of a run over an archive: how it went, and where to look."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dshpm_jax.report._page import make_page, write_page
from dshpm_jax.report._page_name import PAGE_NAME
from dshpm_jax.report._run_summary import summarise


def write_run_page(out: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Writes `out/report.html`, one self-contained page about the results in the folder `out`.

    A row for each trial, those that need somebody first, with its doubts; then subjects and markers. Names lead to
    the pages of trials. It has at most 5 MB: of a very large archive it shows the trials that come first, and says how
    many there are.

    Arguments:
        out: the folder of the results; sidecars are read from there.
        rows: the rows of its manifest. `seconds`, what a file took, is shown where a row has it.

    Raises:
        WriteError: the page cannot be written, or something that is no page of ours has its name.
    """
    title = f"{out.resolve().name}: labelling run"
    write_page(make_page("run", title, {"name": out.resolve().name, **summarise(out, rows).data()}), out / PAGE_NAME)
