"""What the server works on: the trials of a folder, and the one that is open."""

import logging
import threading
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dshpm_jax._archive.said import APPLIED
from dshpm_jax._known import KnownLabel
from dshpm_jax._labelling import Labelling
from dshpm_jax._review.candidates import Evidence, candidates
from dshpm_jax._review.edits import Span
from dshpm_jax._review.gaps import Gaps
from dshpm_jax._review.naming import Source, add_names, sources_of, take_names
from dshpm_jax._review.opening import settings_of
from dshpm_jax._review.places import Place
from dshpm_jax._review.said import known_of
from dshpm_jax._review.session import Solver
from dshpm_jax._review.shown import body_of, room_of, state_of, tracks_of
from dshpm_jax._review.trial import Trial, open_trial
from dshpm_jax._review.waiting import in_hand, queue
from dshpm_jax._review.writing import FILLED, Writer
from dshpm_jax._types import NO_MATCH

_log = logging.getLogger(__name__)


class Desk:
    """The trials of a folder; one is open at a time.

    Arguments:
        places: the trials, by their ids.
        title: of the page.
        opened: the only trial, which is in no file and is never written.
    """

    def __init__(self, places: Mapping[str, Place], title: str, opened: Trial | None = None):
        self.title = title
        self._places = dict(places)
        self._open: Trial | None = opened
        self._in_no_file = opened is not None
        self._lock = threading.RLock()
        self._evidence: tuple[Any, int, Any] = (None, -1, None)
        self._gaps: tuple[Any, Any] = (None, None)
        self._sources: dict[str, Source] = {}
        self._warming: threading.Thread | None = None
        self._trouble = ""
        self.writer = Writer(self._told)

    def queue(self) -> list[dict[str, Any]]:
        """The trials by what is at stake."""
        trial = self._open
        if trial is not None and self._in_no_file:
            return [in_hand(trial.place, self.state(trial)["tracks"])]
        return queue(self._places.values())

    def trial(self, name: str) -> Trial:
        """The trial with an id, opened if it is not; the one that was open is written and closed.

        Raises:
            KeyError: there is none.
            CannotOpen: it cannot be opened.
        """
        with self._lock:
            place = self._places[name]
            if self._open is None or self._open.place.id != name:
                self._close()
                self._open = open_trial(place)
                trial = self._open
                trial.session.kept = lambda: self.writer.touch(trial)
                self._warm(trial)
                if self._is_behind(trial):
                    self.writer.touch(trial)
            return self._open

    def shown(self, trial: Trial) -> dict[str, Any]:
        """All of a trial but its points."""
        with trial.session.lock:
            room, _ = room_of(trial)
            whole = {**room, "in_file": not self._in_no_file}
            return {**whole, **body_of(trial.session.labelling), **self.state(trial)}

    def points(self, trial: Trial) -> bytes:
        with trial.session.lock:
            return room_of(trial)[1].tobytes()

    def state(self, trial: Trial) -> dict[str, Any]:
        """What corrections change, and what is proposed."""
        session = trial.session
        with session.lock:
            found = {**state_of(session, trial.head), "proposal": None}
            if not trial.head:  # nobody labelled it, so there were no sticks to draw
                found["links"] = body_of(session.labelling)["links"]
            if session.proposal is not None:
                known = known_of([*session.standing, session.proposal.correction])
                tracks = tracks_of(session.proposal.labelling, known, trial.head)
                found["proposal"] = {**(session.told() or {}), **tracks}
            return found

    def candidates(self, trial: Trial, track: int) -> list[Any]:
        """See `candidates`."""
        session = trial.session
        with session.lock:
            if not 0 <= track < len(session.labelling.trajectories):
                raise ValueError("there is no such trajectory")
            return candidates(session.labelling, track, self._evidence_of(trial))

    def gaps(self, trial: Trial) -> list[Any]:
        """See `Gaps.listed`."""
        session = trial.session
        with session.lock:
            room, _ = room_of(trial)
            markers = session.labelling.model.markers
            return self._gaps_of(trial).listed(session.fills(), markers, room["axes"])

    def gap_errors(self, trial: Trial, first: int) -> list[Any]:
        """See `Gaps.errors`."""
        with trial.session.lock:
            return self._gaps_of(trial).errors(first)

    def sources(self) -> list[dict[str, Any]]:
        """Where names may come from."""
        self._sources = {source.id: source for source in sources_of(self._places.values())}
        return [{"id": one.id, "text": one.text, "count": len(one.names)} for one in self._sources.values()]

    def name(self, trial: Trial, sent: Mapping[str, Any]) -> None:
        """Gives a trial the names of a source, or further ones.

        Raises:
            KeyError: there is no such source.
            ValueError: it cannot have them.
        """
        with trial.session.lock:
            if "source" in sent:
                take_names(trial, self._sources[sent["source"]])
            else:
                add_names(trial, list(sent["add"]))

    def status(self) -> dict[str, Any]:
        """Whether all is written, and what went wrong where it is not."""
        trial = self._open
        saved = trial is None or self._in_no_file or trial.written == trial.session.version
        return {"saved": saved, "trouble": self._trouble}

    def end(self) -> None:
        """Writes what is due and lets go of the trial."""
        with self._lock:
            self.writer.end()
            if self._warming is not None:
                self._warming.join()
            self._close()

    def _close(self) -> None:
        if self._open is not None and not self._in_no_file:
            self.writer.flush(self._open)
            with self._open.session.lock:  # whatever is solved just now ends first
                self._open.close()
            self._open = None

    def _warm(self, trial: Trial) -> None:
        """Solves, beside all else, what nobody asked for, so that what has to be compiled is when somebody does."""
        labelling, solver = trial.session.labelling, trial.session.solver
        named = np.flatnonzero(labelling.identity != NO_MATCH)
        if solver is None or not len(named):
            return
        tracks = labelling.trajectories
        longest = named[(tracks.stop - tracks.start)[named].argmax()]
        first, last = int(tracks.start[longest]), int(tracks.stop[longest])
        column = labelling.recording.columns[tracks.column[first, tracks.slot[longest]]]
        known = [KnownLabel(column, first, last)]
        self._warming = threading.Thread(target=_quietly, args=(solver, labelling, known), daemon=True)
        self._warming.start()

    def _evidence_of(self, trial: Trial) -> Any:
        if not trial.knows_body:
            return None
        session, (of, version, found) = trial.session, self._evidence
        if of is not trial or version != session.version:
            found = Evidence(session.labelling, settings_of(trial.head))
            self._evidence = trial, session.version, found
        return found

    def _gaps_of(self, trial: Trial) -> Gaps:
        """Those of the labels; accepting one changes none of them."""
        of, found = self._gaps
        if of is not trial.session.labelling:
            if trial.place.result.suffix.lower() != ".c3d":
                raise ValueError(
                    "gaps are filled in C3D files alone, where filled points can be told from measured ones"
                )
            if not trial.knows_body:
                raise ValueError("gaps are filled by a model of the subject, and this trial has none")
            found = Gaps(trial.session.labelling)
            self._gaps = trial.session.labelling, found
        return found

    def _is_behind(self, trial: Trial) -> bool:
        """Whether the result lacks corrections, as after a crash."""
        there = [(name, Span(*span)) for name, span in trial.head.get(FILLED, ())]
        applied = list(trial.head.get(APPLIED, ()))
        return [one.id for one in trial.session.standing] != applied or trial.session.fills() != there

    def _told(self, line: str) -> None:
        self._trouble = line


def _quietly(solver: Solver, labelling: Labelling, known: Sequence[KnownLabel]) -> None:
    try:
        solver(labelling, known)
    except Exception:
        _log.debug("nothing could be solved ahead", exc_info=True)
