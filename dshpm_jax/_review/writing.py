"""What a person decided, written into the results: labelled file, sidecar, page, and those of the folder."""

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from dshpm_jax._archive.hashes import INPUT, SETTINGS, hash_file, hash_settings
from dshpm_jax._archive.manifest import Manifest, known_rows
from dshpm_jax._archive.outcomes import figures_of, judged
from dshpm_jax._archive.results import write_result
from dshpm_jax._archive.said import Said
from dshpm_jax._review.gaps import Gaps
from dshpm_jax._review.opening import settings_of
from dshpm_jax._review.trial import Trial
from dshpm_jax.report._run_page import write_run_page

SOON = 1.0
"""Seconds; used in `Writer`: a result is written when nothing was corrected for this long."""

LATER = 5.0
"""Seconds; used in `Writer`: summary and report are written when no result was for this long."""

FILLED = "filled"
"""In sidecars: the gaps that are filled in the labelled file: a marker, and frames `first <= t < last`."""

_log = logging.getLogger(__name__)


def write_back(trial: Trial) -> None:
    """Writes the labels of a trial into its result, whole or not at all, and a row for its folder.

    Raises:
        ReadError, WriteError, OSError, ResultKept: it cannot be written; the corrections are kept all the same.
    """
    session, place = trial.session, trial.place
    with session.lock:
        labelling, version, fills = session.labelling, session.version, session.fills()
        said = Said(session.known(), tuple(one.id for one in session.standing))
    settings = settings_of(trial.head)
    figures = figures_of(labelling)
    hashes = {SETTINGS: hash_settings(settings), INPUT: hash_file(place.job.source), **trial.head.get("hashes", {})}
    record = {"settings": asdict(settings), "figures": figures, **said.record, **({FILLED: fills} if fills else {})}

    def finish(path: Path) -> None:
        if fills and path.suffix.lower() == ".c3d":
            Gaps(labelling).fill(labelling, fills, path)

    write_result(labelling, place.job, place.out, hashes, record, finish)
    outcome = judged(place.job, settings, hashes, figures | {"stats": labelling.stats})
    trial.written = version
    manifest = Manifest(place.out)
    manifest.add(replace(outcome, seconds=place.row.get("seconds")))


def write_folder(out: Path) -> None:
    """Writes manifest, summary and report of a folder anew."""
    manifest = Manifest(out)
    manifest.close()
    write_run_page(out, list(known_rows(out).values()))


class Writer:
    """Writes back in a thread of its own, a little after the last correction, and at the end.

    Arguments:
        told: is called with a line when something could not be written, and with nothing when all is.
    """

    def __init__(self, told: Callable[[str], Any] = lambda line: None):
        self._told = told
        self._due: dict[str, tuple[Trial, float]] = {}
        self._folders: dict[Path, float] = {}
        self._change = threading.Condition()
        self._writing = threading.Lock()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="writer", daemon=True)
        self._thread.start()

    def touch(self, trial: Trial) -> None:
        """A trial has something new to write."""
        with self._change:
            self._due[trial.place.id] = trial, time.monotonic() + SOON
            self._change.notify()

    def flush(self, trial: Trial | None = None) -> None:
        """Writes what is due of a trial now, or of all and of their folders."""
        with self._change:
            names = list(self._due) if trial is None else [name for name in self._due if name == trial.place.id]
            trials = [self._due.pop(name)[0] for name in names]
        for one in trials:
            self._write(one)
        if trial is None:
            with self._change:
                folders, self._folders = list(self._folders), {}
            for folder in folders:
                self._write_folder(folder)

    def end(self) -> None:
        """Writes all that is due and stops."""
        with self._change:
            self._ended = True
            self._change.notify()
        self._thread.join()
        self.flush()

    def _run(self) -> None:
        while True:
            with self._change:
                if self._ended:
                    return
                times = [when for _, when in self._due.values()] + list(self._folders.values())
                self._change.wait(max(0.05, min(times) - time.monotonic()) if times else None)
                now = time.monotonic()
                trials = [name for name, (_, when) in self._due.items() if when <= now]
                ready = [self._due.pop(name)[0] for name in trials]
                folders = [path for path, when in self._folders.items() if when <= now and not ready]
                for path in folders:
                    del self._folders[path]
            for trial in ready:
                self._write(trial)
            for folder in folders:
                self._write_folder(folder)

    def _write(self, trial: Trial) -> None:
        with self._writing:
            try:
                write_back(trial)
            except Exception as error:
                _log.debug("a result cannot be written", exc_info=True)
                self._told(f"{trial.place.name}: not written ({error}); your corrections are kept")
                return
        self._told("")
        with self._change:
            self._folders[trial.place.out] = time.monotonic() + LATER
            self._change.notify()

    def _write_folder(self, folder: Path) -> None:
        with self._writing:
            try:
                write_folder(folder)
            except Exception as error:
                _log.debug("a folder cannot be written", exc_info=True)
                self._told(f"{folder}: its report is not written ({error}); your corrections are kept")
