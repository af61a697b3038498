"""The command `label`: its options, and what it does with them."""

import argparse
import dataclasses
import re
from collections.abc import Sequence
from contextlib import closing
from functools import partial
from pathlib import Path

from dshpm_jax._archive.dispatcher import label_on
from dshpm_jax._archive.jobs import FORMATS, Job, find_jobs, in_shard
from dshpm_jax._archive.manifest import known_rows
from dshpm_jax._archive.progress import TICK_SECONDS, Progress, every, log_to
from dshpm_jax._archive.result_status import Due
from dshpm_jax._archive.run import Executor, Order, label_archive, label_here, what_is_due
from dshpm_jax._archive.workers import local_workers, workers_of
from dshpm_jax._commands.forms import add_form, form_of
from dshpm_jax._commands.pages import add_open, open_page
from dshpm_jax._commands.statuses import FAILURES, OK
from dshpm_jax._compile_cache import cache_folder
from dshpm_jax._console import add_reading, complain, say
from dshpm_jax._messages import UsageError
from dshpm_jax._settings import Settings
from dshpm_jax.io import WriteError
from dshpm_jax.report._page_name import PAGE_NAME

ABOUT = "labels recordings"
MOST_INPUTS = 3  # named in a line


def add_options(label: argparse.ArgumentParser) -> None:
    """The options of `label`."""
    label.add_argument("inputs", nargs="+", type=Path, metavar="INPUT", help="a recording, or a folder of them")
    label.add_argument(
        "-o", "--output", dest="out", type=Path, required=True, metavar="OUT", help="folder for the results"
    )
    label.add_argument(
        "--model",
        type=Path,
        action="append",
        default=[],
        metavar="MODEL",
        help="once for each subject, or a marker set; otherwise the nearest model.json of each file",
    )
    add_form(label.add_argument_group("how results are written"), FORMATS)
    _add_how(label.add_argument_group("how to label"))
    _add_run(label.add_argument_group("the run"))


def _add_how(how: argparse._ArgumentGroup) -> None:
    """The options that decide which labels come out."""
    how.add_argument("--method", choices=("full", "paper", "static"), help="how to label (default: full)")
    how.add_argument("--settings", type=Path, metavar="FILE", help="TOML file with the method and its parameters")
    how.add_argument(
        "--rescale",
        action="store_true",
        default=None,
        help="the model is another subject's of the same marker set: make it fit each recording first (slow)",
    )
    how.add_argument(
        "--apart",
        action="store_true",
        help="with a marker set: recordings of one folder are of different subjects",
    )
    how.add_argument(
        "--confidence", type=float, metavar="X", help="labels less likely to be right stay away (default: 0.7)"
    )
    how.add_argument(
        "--completeness",
        type=float,
        metavar="X",
        help="a file counts as partly labelled if less of its markers' points have a label (default: 0.5)",
    )
    how.add_argument(
        "--keep-labels",
        action="store_true",
        default=None,
        help="names that the file has are right: keep them, and label the rest around them",
    )
    how.add_argument(
        "--frames",
        type=_frames,
        metavar="A:B",
        help="with --keep-labels: they are right in frames A to B, as the file numbers them",
    )
    add_reading(how)


def _add_run(run: argparse._ArgumentGroup) -> None:
    """The options that decide what is done, where, and what is told."""
    run.add_argument("--dry-run", action="store_true", help="list what would be done, with which model; write nothing")
    run.add_argument("--force", action="store_true", help="make earlier results again, even if nothing changed")
    where = run.add_mutually_exclusive_group()
    where.add_argument("--workers", type=_count, metavar="N", help="label in N processes (default: in this one)")
    where.add_argument("--scheduler", metavar="ADDRESS", help="label on the workers of this dask scheduler")
    where.add_argument("--scheduler-file", type=Path, metavar="FILE", help="the same, by the file that it wrote")
    run.add_argument("--shard", type=_shard, metavar="I/N", help="only share I (from 0) of N, for job arrays")
    run.add_argument("--no-pages", action="store_true", help="make no page of each trial, which 'view' makes too")
    add_open(run, "the report, when all is done,")
    run.add_argument("--log-file", type=Path, metavar="FILE", help="append what happens to this file, with times")


def run(arguments: argparse.Namespace) -> int:
    """Labels, and gives the exit status: 0 all labelled, 1 not all, or some doubtful."""
    settings = _settings(arguments)
    for model in arguments.model:
        if not model.is_file():
            raise UsageError(f"{model}: there is no such model; make one with 'dshpm-jax model'")
    if arguments.shard and (arguments.scheduler or arguments.scheduler_file):
        raise UsageError("--shard: the workers of a scheduler share out all files themselves; leave one of them out")
    form = form_of(arguments)
    if not arguments.dry_run:
        say(f"looking for recordings in {_listed(arguments.inputs)}")
    jobs = find_jobs(arguments.inputs, arguments.model, arguments.out, arguments.format, form)
    jobs = [dataclasses.replace(job, page=not arguments.no_pages) for job in jobs]
    if arguments.apart:
        jobs = [dataclasses.replace(job, beside=()) for job in jobs]
    order = Order(arguments.out, settings, arguments.force, arguments.shard, arguments.workers or 1)
    if order.shard:
        jobs = in_shard(jobs, order.shard)
    if arguments.dry_run:
        return _say_what_is_due(jobs, order)
    cache_folder()  # complains here if it has to, and not in every worker
    log = log_to(arguments.log_file) if arguments.log_file else None
    try:
        status = _label(jobs, order, _executor(arguments))
    finally:
        if log:
            log.close()
    if arguments.open:
        open_page(order.out)
    return status


def _executor(arguments: argparse.Namespace) -> Executor:
    """Where to label."""
    if arguments.workers:
        return label_on(partial(local_workers, arguments.workers))
    if arguments.scheduler or arguments.scheduler_file:
        return label_on(partial(workers_of, arguments.scheduler, arguments.scheduler_file))
    return label_here


def _label(jobs: Sequence[Job], order: Order, executor: Executor) -> int:
    progress = Progress(jobs)
    whole = False
    order = dataclasses.replace(order, notice=progress.notice)
    try:
        with every(TICK_SECONDS, progress.tick), closing(label_archive(jobs, order, executor)) as outcomes:
            for outcome in outcomes:
                progress.take(outcome)
        whole = True
    except WriteError as error:
        complain(error)
    finally:
        progress.end(order.out, order.out / PAGE_NAME if whole else None)
    return OK if whole and progress.all_labelled else FAILURES


def _listed(inputs: Sequence[Path]) -> str:
    more = f" and {len(inputs) - MOST_INPUTS} more" if len(inputs) > MOST_INPUTS else ""
    return ", ".join(map(str, inputs[:MOST_INPUTS])) + more


def _say_what_is_due(jobs: Sequence[Job], order: Order) -> int:
    """A line for each file, and the exit status: 1 if some cannot be labelled."""
    num_due = num_wrong = 0
    for found in what_is_due(jobs, order, known_rows(order.out)):
        if isinstance(found, Due):
            job = found.job
            models = " and ".join(map(str, job.models))
            say(f"{job.source}: would be labelled with {models} into {order.out / job.target}; it {found.why}")
            num_due += 1
            continue
        if found.message:
            complain(found.message)
        if found.ok:
            say(f"{found.job.source}: up to date")
        else:
            num_wrong += 1
    say(f"{num_due} of {len(jobs)} recordings would be labelled")
    return FAILURES if num_wrong else OK


def _settings(arguments: argparse.Namespace) -> Settings:
    """Those of the file, and what else the command says."""
    said = {
        "method": arguments.method,
        "rescale": arguments.rescale,
        "completeness": arguments.completeness,
        "min_confidence": arguments.confidence,
        "unlabelled": arguments.unlabelled or None,
        "drop": arguments.drop or None,
        "frozen_gaps": False if arguments.keep_frozen else None,
        "keep_labels": arguments.keep_labels,
        "keep_frames": arguments.frames,
    }
    try:
        settings = Settings.from_toml(arguments.settings) if arguments.settings else Settings()
        settings = dataclasses.replace(settings, **{name: value for name, value in said.items() if value is not None})
    except ValueError as error:
        raise UsageError(str(error)) from None
    if arguments.confidence is not None and settings.method != "full":
        raise UsageError(f"--confidence: the method '{settings.method}' withholds no labels; leave one of them out")
    return settings


def _count(text: str) -> int:
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f"'{text}' is no number of processes, such as 2")
    return int(text)


def _frames(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d+):(\d+)", text)
    if not found or int(found[2]) < int(found[1]):
        raise argparse.ArgumentTypeError(f"'{text}' is no range of frames such as 1:100")
    return int(found[1]), int(found[2])


def _shard(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if not found or not int(found[1]) < int(found[2]):
        raise argparse.ArgumentTypeError(f"'{text}' is no share such as 0/4, 1/4, 2/4 or 3/4")
    return int(found[1]), int(found[2])
