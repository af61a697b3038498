"""The command `view`: a page for each labelled recording, and for all results of a run."""

import argparse
from collections.abc import Iterator
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._archive.manifest import MANIFEST_NAME, known_rows
from dshpm_jax._commands.pages import add_open, open_page
from dshpm_jax._commands.statuses import FAILURES, OK
from dshpm_jax._console import complain, say
from dshpm_jax._messages import UsageError
from dshpm_jax._model import SubjectModel
from dshpm_jax.report._page import is_page
from dshpm_jax.report._page_name import page_of_result
from dshpm_jax.report._run_page import write_run_page
from dshpm_jax.report._view import view

ABOUT = "a page in which a labelled recording plays"


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of `view`."""
    about = "labelled recording, or a folder of results"
    parser.add_argument("inputs", nargs="+", type=Path, metavar="FILE", help=about)
    parser.add_argument(
        "-o",
        "--output",
        dest="out",
        type=Path,
        metavar="PAGE",
        help="the page (HTML); by default beside the file and named like it",
    )
    parser.add_argument("--model", type=Path, metavar="MODEL", help="gives the segments where no sidecar does")
    add_open(parser, "the first page, or the report of a folder,")


def run(arguments: argparse.Namespace) -> int:
    """Makes pages, and gives the exit status: 1 if some could not be made."""
    inputs, out = arguments.inputs, arguments.out
    if out and (len(inputs) > 1 or inputs[0].is_dir()):
        raise UsageError(f"{out}: is one page, but there may be several recordings; leave -o out")
    if out and out.exists() and not is_page(out):
        raise UsageError(f"{out}: is there and no page of ours, not overwritten; give another file")
    if out and not out.parent.is_dir():
        raise UsageError(f"{out.parent}: there is no such folder; make it or give another file")
    try:
        model = io.read_model(arguments.model) if arguments.model else None
    except io.ReadError as error:
        raise UsageError(str(error)) from None
    troubles = [trouble for given in inputs for trouble in _pages_of(given, out, model)]
    for trouble in troubles:
        complain(trouble)
    if arguments.open:
        open_page(inputs[0] if inputs[0].is_dir() else out or inputs[0].with_suffix(".html"))
    return FAILURES if troubles else OK


def _pages_of(given: Path, out: Path | None, model: SubjectModel | None) -> Iterator[str]:
    """Makes the pages of one input; yields a line for each that could not be made."""
    if not given.is_dir():
        yield from _page(given, out or given.with_suffix(".html"), model)
        return
    if not (given / MANIFEST_NAME).is_file():
        yield f"{given}: holds no {MANIFEST_NAME}; give a labelled recording, or a folder that 'label' wrote"
        return
    rows = sorted(known_rows(given).values(), key=lambda row: row["output"] or row["input"])
    for row in rows:
        if row["output"] and (given / row["output"]).is_file():
            yield from _page(given / row["output"], page_of_result(given, given / row["output"]), model)
    try:
        write_run_page(given, rows)  # which links to the pages from now on
    except io.WriteError as error:
        yield str(error)


def _page(recording: Path, page: Path, model: SubjectModel | None) -> Iterator[str]:
    try:
        view(recording, model).save(page)
    except (io.ReadError, io.WriteError) as error:
        yield str(error)
    except ValueError as error:
        yield f"{recording}: {error}"
    except KeyError as error:
        yield f"{recording}: its sidecar names {error}, which is not there; label it again, or move the sidecar away"
    else:
        say(page)
