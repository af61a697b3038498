"""`report.html` of a run over an archive: how it went, and where to look."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dshpm_jax.report._page import make_page, write_page
from dshpm_jax.report._run_summary import summarise

PAGE_NAME = "report.html"


def write_run_page(out: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Writes `out/report.html`, one self-contained page about the results in the folder `out`.

    Files by completeness and confidence, labels that are least sure, and gaps by label; it links to each result, and to
    the page that `dshpm-jax view` made beside it, if there is one.

    Arguments:
        out: the folder of the results; sidecars are read from there.
        rows: the rows of its manifest. `seconds`, what a file took, is shown where a row has it.

    Raises:
        WriteError: the page cannot be written, or something that is no page of ours has its name.
    """
    title = f"{out.resolve().name}: labelling run"
    write_page(make_page("run", title, {"name": out.resolve().name, **summarise(out, rows).data()}), out / PAGE_NAME)
