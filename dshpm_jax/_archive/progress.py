"""What people see of a run: a bar on a terminal, plain lines elsewhere, and all of it in the log file."""

import logging
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.outcomes import FAILED, KEPT, LABELLED, PARTLY, PASSED, Outcome
from dshpm_jax._console import complain, say
from dshpm_jax._messages import UsageError

STATUS_SECONDS = 60.0  # between two lines of status where there is no bar
_HEAD = "# log of dshpm-jax label\n"

_log = logging.getLogger(__name__)


class Progress:
    """Counts outcomes and tells of them.

    Arguments:
        jobs: all jobs of the run.
        clock: seconds that only grow.
    """

    def __init__(self, jobs: Sequence[Job], clock: Callable[[], float] = time.monotonic):
        self.counts: Counter[str] = Counter()
        self._sizes = {job: job.source.stat().st_size if job.source.is_file() else 0 for job in jobs}
        self._left = sum(self._sizes.values())
        self._bytes = self._frames = 0  # of what was labelled in this run
        self._clock = clock
        self._start = self._said = self._last = clock()
        self._bar = _bar(len(jobs))

    def take(self, outcome: Outcome) -> None:
        """Tells of one more outcome."""
        now = self._clock()
        if self._bar is None and now - self._said >= STATUS_SECONDS:
            self._said = now
            say(f"{self.counts.total()} of {len(self._sizes)} files, {self._status()}")
        self._last = now
        self.counts[outcome.outcome] += 1
        size = self._sizes.get(outcome.job, 0)
        self._left -= size
        if outcome.figures and not outcome.was_there:
            self._bytes += size
            self._frames += outcome.figures["frames"]
        self._tell(outcome)
        if self._bar is not None:
            self._bar.set_postfix_str(self._status(), refresh=False)
            self._bar.update()

    @property
    def all_labelled(self) -> bool:
        """Whether every file is labelled that there is anything to label in."""
        return self.counts[LABELLED] + self.counts[PASSED] == len(self._sizes)

    def end(self, out: Path) -> None:
        """Takes the bar away and says how it went."""
        if self._bar is not None:
            self._bar.close()
        counts = [f"{self.counts[what]} {what}" for what in (PARTLY, KEPT, PASSED, FAILED) if self.counts[what]]
        line = ", ".join([f"{self.counts[LABELLED]} of {len(self._sizes)} recordings labelled", *counts])
        say(f"{line}, results in {out}")
        _log.info("%s", line)

    def _tell(self, outcome: Outcome) -> None:
        for note in outcome.notes:
            complain(f"{outcome.job.source}: {note}")
            _log.warning("%s: %s", outcome.job.source, note)
        if outcome.message:
            complain(outcome.message)
            _log.warning("%s", outcome.message)
        if outcome.detail:
            _log.debug("%s", outcome.detail)
        if outcome.figures:
            say(_line(outcome))
            _log.info("%s", _line(outcome))

    def _status(self) -> str:
        """Such as "83 frames/s, 118 labelled, 1 partly labelled, 1 failed, expected end Sat 14:35"."""
        parts = [f"{self.counts[what]} {what}" for what in (LABELLED, PARTLY, FAILED)]
        seconds = self._last - self._start  # outcomes come in batches; the one on its way does not count yet
        if self._bytes and seconds > 0:
            end = datetime.now() + timedelta(seconds=self._left * seconds / self._bytes)
            parts = [f"{self._frames / seconds:.0f} frames/s", *parts, f"expected end {end:%a %H:%M}"]
        return ", ".join(parts)


def log_to(path: Path) -> logging.Handler:
    """Appends all that happens to a log file, with times and tracebacks; a file that is no log of ours is refused."""
    try:
        if path.exists() and not path.read_bytes().startswith(_HEAD.encode()):
            raise UsageError(f"{path}: is there and no log of ours, not appended to; give another file")
        if not path.exists():
            path.write_text(_HEAD)
        handler = logging.FileHandler(path, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{path}: cannot be written ({error.strerror}); give another file") from None
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    logger = logging.getLogger("dshpm_jax")
    logger.setLevel(logging.DEBUG)
    logger.addHandler(handler)
    return handler


def _line(outcome: Outcome) -> str:
    source, figures = outcome.job.source, outcome.figures
    if outcome.was_there:
        return f"{source}: up to date"
    tracks = f"{figures['labelled_trajectories']} of {figures['trajectories']} trajectories"
    return f"{source}: {outcome.outcome}, {figures['completeness']:.1%} of the markers found, {tracks}"


def _bar(total: int) -> Any:
    if not sys.stderr.isatty():
        return None
    from tqdm import tqdm

    return tqdm(total=total, unit="file", bar_format="{l_bar}{bar}| {n_fmt}/{total_fmt} files{postfix}")
