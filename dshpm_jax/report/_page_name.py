"""What pages of a run are called."""

from pathlib import Path

PAGE_NAME = "report.html"  # of the run itself


def page_of_result(out: Path, result: Path) -> Path:
    """The page of a result in the folder `out`: beside it and named like it, but not where the run's own page is."""
    page = result.with_suffix(".html")
    return page if page != out / PAGE_NAME else result.with_name(f"{result.name}.html")
