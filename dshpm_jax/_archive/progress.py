"""What people see of a run: a bar on a terminal, plain lines elsewhere, and all of it in the log file."""

import logging
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import datetime, timedelta
from pathlib import Path
from threading import Event, RLock, Thread
from typing import Any

from dshpm_jax._archive.completeness import percent
from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.outcomes import Outcome
from dshpm_jax._console import complain, say
from dshpm_jax._messages import UsageError
from dshpm_jax._outcomes import LABELLED, PASSED, WORST_FIRST

TICK_SECONDS = 2.0  # between two calls of `Progress.tick`
STATUS_SECONDS = 30.0  # between two lines of status where there is no bar
MOST_NAMES = 6  # of markers in a line
_HEAD = "# log of dshpm-jax label\n"

_log = logging.getLogger(__name__)


class Progress:
    """Counts outcomes and tells of them; of how far the run is it tells by the clock, see `tick`.

    Arguments:
        jobs: all jobs of the run.
        clock: seconds that only grow.
    """

    def __init__(self, jobs: Sequence[Job], clock: Callable[[], float] = time.monotonic):
        self.counts: Counter[str] = Counter()
        self._sizes = {job: job.source.stat().st_size if job.source.is_file() else 0 for job in jobs}
        self._left = sum(self._sizes.values())
        self._bytes = self._frames = 0  # of what was labelled in this run
        self._doing = ""
        self._noticed: set[str] = set()
        self._clock = clock
        self._start = self._said = self._last = clock()
        self._lock = RLock()  # lines come from two threads
        self._bar = _bar(len(jobs))

    def notice(self, line: str) -> None:
        """Takes what is going on: a line of its own until the first result is there, then part of the status."""
        with self._lock:
            self._doing = line
            _log.info("%s", line)
            if not self._bytes and line not in self._noticed:
                self._noticed.add(line)
                say(line)

    def tick(self) -> None:
        """Renews the bar, or says how far the run is if that was not said for long; to be called every few seconds."""
        with self._lock:
            now = self._clock()
            if self._bar is not None:
                self._bar.set_postfix_str(", ".join(self._status()), refresh=True)
            elif now - self._said >= STATUS_SECONDS:
                self._said = now
                say(", ".join([f"{self.counts.total()} of {len(self._sizes)} files", *self._status()]))

    def take(self, outcome: Outcome) -> None:
        """Tells of one more outcome."""
        with self._lock:
            self._last = self._clock()
            self.counts[outcome.outcome] += 1
            size = self._sizes.get(outcome.job, 0)
            self._left -= size
            if outcome.figures and not outcome.was_there:
                self._bytes += size
                self._frames += outcome.figures["frames"]
            self._tell(outcome)
            if self._bar is not None:
                self._bar.set_postfix_str(", ".join(self._status()), refresh=False)
                self._bar.update()

    @property
    def all_labelled(self) -> bool:
        """Whether every file is labelled that has points, and no label is doubtful."""
        return self.counts[LABELLED] + self.counts[PASSED] == len(self._sizes)

    def end(self, out: Path, page: Path | None = None) -> None:
        """Takes the bar away and says how it went, and where the page about the run is."""
        if self._bar is not None:
            self._bar.close()
        others = [what for what in WORST_FIRST if what != LABELLED and self.counts[what]]
        counts = [f"{self.counts[what]} {what}" for what in others]
        line = ", ".join([f"{self.counts[LABELLED]} of {len(self._sizes)} recordings labelled", *counts])
        say(f"{line}, results in {out}")
        _log.info("%s", line)
        if page is not None:
            say(f"open {page} in a browser to see what needs you")

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

    def _status(self) -> list[str]:
        """Such as "83 frames/s", "1 failed", "118 labelled", "expected end Sat 14:35", "reading 12 files"."""
        parts = [f"{self.counts[what]} {what}" for what in WORST_FIRST if self.counts[what]]
        seconds = self._last - self._start  # what is in flight does not count yet
        if self._bytes and seconds > 0:
            end = datetime.now() + timedelta(seconds=self._left * seconds / self._bytes)
            parts = [f"{self._frames / seconds:.0f} frames/s", *parts, f"expected end {end:%a %H:%M}"]
        return [*parts, self._doing] if self._doing else parts


@contextmanager
def every(seconds: float, call: Callable[[], object]) -> Iterator[None]:
    """Calls something every so many seconds, in a thread of its own, until the block ends."""
    over = Event()

    def go_on() -> None:
        while not over.wait(seconds):
            try:
                call()
            except OSError:  # nobody reads any more, which who started the run finds out
                return

    thread = Thread(target=go_on, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


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
    unseen = _names(figures["never_seen"]) if figures["labelled_trajectories"] else ""
    line = f"{source}: {outcome.outcome}, {percent(figures['completeness'])} of the markers' points, {tracks}"
    return f"{line}, never seen: {unseen}" if unseen else line


def _names(markers: Sequence[str]) -> str:
    more = f" and {len(markers) - MOST_NAMES} more" if len(markers) > MOST_NAMES else ""
    return ", ".join(markers[:MOST_NAMES]) + more


def _bar(total: int) -> Any:
    if not sys.stderr.isatty():
        return None
    from tqdm import tqdm

    return tqdm(total=total, unit="file", bar_format="{l_bar}{bar}| {n_fmt}/{total_fmt} files{postfix}")
