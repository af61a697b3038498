"""A result appears whole, with sidecar and page, or not at all, and never in the place of a file that has to stay."""

import logging
import os
import re
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from shutil import rmtree
from typing import Any

from dshpm_jax import io
from dshpm_jax._archive.hashes import INPUT, hash_file
from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.result_status import kept_because, replaced_by
from dshpm_jax._labelling import Labelling
from dshpm_jax.report._page_name import page_of_result
from dshpm_jax.report._view import view, write_trial_page

_log = logging.getLogger(__name__)

_UNFINISHED = re.compile(r"\.(?P<target>.+)\.[a-z0-9_]{8}\.part")  # as tempfile names them


class ResultKept(Exception):
    """The file in the result's place must not be overwritten."""


def write_result(
    labelling: Labelling,
    job: Job,
    out: Path,
    hashes: Mapping[str, str],
    record: Mapping[str, Any],
    finish: Callable[[Path], object] = lambda path: None,
) -> None:
    """Writes the labelled file and its sidecar, which holds `hashes`, `record` and the hash of the labelled file.

    Arguments:
        finish: is called with the labelled file before anybody else sees it, and may change it.

    Raises:
        ResultKept: somebody put another file there while the recording was labelled.
        ReadError: the recording changed meanwhile.
        OSError, WriteError: the result cannot be written.
    """
    target, sidecar = out / job.target, out / job.sidecar
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{target.name}.", suffix=".part", dir=target.parent) as folder:
        new = Path(folder) / target.name, Path(folder) / sidecar.name
        io.write_labelled(labelling, new[0], job.form)
        finish(new[0])
        about = {"hashes": dict(hashes), "result": target.name, "output": hash_file(new[0])}
        io.write_sidecar(labelling, new[1], about | dict(record))
        if hash_file(job.source) != hashes[INPUT]:
            raise io.ReadError(job.source, "changed while it was labelled", "label it again when it is complete")
        if reason := kept_because(target, sidecar):
            raise ResultKept(reason)
        if job.page:
            _make_page(labelling, dict(record), page_of_result(out, target), target.name)
        earlier = replaced_by(target, sidecar)
        # A run that is killed here leaves no result beside a sidecar that does not belong to it.
        for path in (target, earlier):
            if path is not None:
                path.unlink(missing_ok=True)
        os.replace(new[1], sidecar)
        os.replace(new[0], target)


def _make_page(labelling: Labelling, record: Mapping[str, Any], page: Path, name: str) -> None:
    """Makes the page of a result, which counts without it: what somebody put in the page's place stays."""
    try:
        write_trial_page(labelling, record, page, name)
    except Exception:
        _log.warning("%s: no page could be made", page, exc_info=True)


def make_missing_page(job: Job, out: Path) -> None:
    """Makes the page of a result that is up to date where it should have one: an earlier run may have made none."""
    result = out / job.target
    page = page_of_result(out, result)
    if not job.page or page.exists():
        return
    try:
        view(result).save(page)
    except Exception:
        _log.warning("%s: no page could be made", page, exc_info=True)


def remove_unfinished(jobs: Iterable[Job], out: Path) -> None:
    """Removes what an earlier run that was killed left unfinished of the results of `jobs`."""
    targets = {out / job.target for job in jobs}
    for here, folders, _ in os.walk(out):
        for name in list(folders):
            found = _UNFINISHED.fullmatch(name)
            if found and Path(here) / found["target"] in targets:
                folders.remove(name)
                rmtree(Path(here) / name, ignore_errors=True)
