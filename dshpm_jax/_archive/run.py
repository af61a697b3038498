"""A run over an archive: what is due goes in batches to where it is labelled, and every file gets a row."""

import logging
import math
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from dshpm_jax._archive.batch import Notice, label_batch
from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.manifest import Manifest, Row
from dshpm_jax._archive.outcomes import Outcome
from dshpm_jax._archive.own_models import forget_own_models
from dshpm_jax._archive.result_status import Due, ResultStatus
from dshpm_jax._archive.results import make_missing_page, remove_unfinished
from dshpm_jax._messages import UsageError
from dshpm_jax._settings import Settings
from dshpm_jax.io import WriteError
from dshpm_jax.report._run_page import write_run_page

BATCH_FILES = 16  # in one batch; twice as many fill the kernels hardly better
BATCH_GROWTH = 4  # of the number of files, from one in the first batch, so that its result is there soon
BATCH_BYTES = 16 << 20  # of files in one batch, which bounds its memory and what is lost if it is interrupted

_REMEDY = "the same command makes it again from the results"

_log = logging.getLogger(__name__)


def _say_nothing(line: str) -> None:
    pass


@dataclass(frozen=True)
class Order:
    """What a run is asked for.

    Attributes:
        out: the folder for the results.
        force: whether results that are up to date are made again.
        shard: which shard of how many this run is, if it does not do all (see `in_shard`).
        workers: how many label side by side; batches are small enough that each gets some.
        notice: takes lines about what is going on, such as "reading 12 files".
    """

    out: Path
    settings: Settings = Settings()
    force: bool = False
    shard: tuple[int, int] | None = None
    workers: int = 1
    notice: Notice = _say_nothing


Step = Outcome | list[Job]
"""A file with nothing to do, or a batch to label."""

Executor = Callable[[Iterator[Step], Order], Iterator[Outcome]]
"""Where batches are labelled; passes on the outcomes of files with nothing to do."""


def label_here(steps: Iterator[Step], order: Order) -> Iterator[Outcome]:
    """Labels in this process."""
    for step in steps:
        if isinstance(step, Outcome):
            yield step
        else:
            yield from label_batch(step, order.out, order.settings, order.notice)


def label_archive(jobs: Sequence[Job], order: Order, executor: Executor = label_here) -> Generator[Outcome, None, None]:
    """Labels recordings into `order.out`, and gives their outcomes one by one.

    Files of like size go together, the small ones first. A file that fails harms no other. What is there and up to
    date is left alone; a result is made again if its input, model or settings changed, but files that are none of our
    results or that somebody changed stay. The folder gets a manifest with a row for each file, whichever run it was
    labelled in.

    Raises:
        UsageError: nothing can be written into the folder, or files of somebody else have the names of the manifest's.
        WriteError: no manifest or report could be written at the end.
    """
    try:
        manifest = Manifest(order.out, order.shard)
        remove_unfinished(jobs, order.out)
        if order.force:
            forget_own_models(jobs, order.out)
    except OSError as error:
        remedy = "give another folder for the results"
        raise UsageError(f"{order.out}: cannot be written ({error.strerror}); {remedy}") from None
    try:
        for outcome in executor(_steps(jobs, order, manifest.rows), order):
            manifest.add(outcome)
            if outcome.was_there:
                make_missing_page(outcome.job, order.out)
            yield outcome
    finally:
        _close(manifest, order.out)
    _write_page(manifest, order.out)


def what_is_due(jobs: Iterable[Job], order: Order, rows: Mapping[str, Row]) -> Iterator[Due | Outcome]:
    """What `label_archive` would do with each job, given the `known_rows` of its folder; writes nothing."""
    owners = {row["output"]: row["input"] for row in rows.values() if row["output"]}
    status = ResultStatus(order.out, order.settings, order.force, owners)
    return (status.of(job) for job in jobs)


def _steps(jobs: Sequence[Job], order: Order, rows: Mapping[str, Row]) -> Iterator[Step]:
    """Recordings of like size together, so that little of a batch is padding."""
    sizes = {job: _size(job.source) for job in jobs}
    batch: list[Job] = []
    sent = 0
    most = _most(len(jobs), sent, order.workers)
    small_first = sorted(jobs, key=lambda job: (sizes[job], str(job.source)))
    for seen, due in enumerate(what_is_due(small_first, order, rows)):
        if isinstance(due, Outcome):
            yield due
            continue
        total = sum(sizes[job] for job in batch) + sizes[due.job]
        if batch and (len(batch) == most or total > BATCH_BYTES):
            yield batch
            sent += 1
            batch, most = [], _most(len(jobs) - seen, sent, order.workers)
        batch.append(due.job)
    if batch:
        yield batch


def _most(left: int, sent: int, workers: int) -> int:
    """Files of the next batch, of those left, after `sent` batches.

    At first few, so that the first results are soon there, and towards the end fewer, so that all workers end at about
    the same time.
    """
    grown = min(BATCH_FILES, BATCH_GROWTH ** min(sent // workers, BATCH_FILES))
    return grown if workers == 1 else min(grown, math.ceil(left / (2 * workers)))


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else 0


def _close(manifest: Manifest, out: Path) -> None:
    try:
        manifest.close()
    except OSError as error:
        raise WriteError(out, f"no manifest can be written ({error.strerror})", _REMEDY) from None


def _write_page(manifest: Manifest, out: Path) -> None:
    try:
        write_run_page(out, list(manifest.rows.values()))
    except WriteError:
        raise
    except Exception as error:  # a sidecar that somebody edited, say
        _log.debug("no page can be made", exc_info=True)
        raise WriteError(out, f"no page can be made ({type(error).__name__}: {error})", _REMEDY) from None
