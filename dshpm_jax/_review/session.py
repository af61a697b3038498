"""One trial in hand: its labels, what was done to them, and what is proposed but does not count yet."""

import getpass
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from threading import RLock
from typing import Any, Protocol

import numpy as np

from dshpm_jax._corrections import Change, Correction
from dshpm_jax._corrections._format import resolved
from dshpm_jax._known import KnownLabel
from dshpm_jax._labelling import Labelling
from dshpm_jax._review import edits
from dshpm_jax._review.edits import Edit, Span
from dshpm_jax._review.pieces import (
    Effect,
    adopted,
    after,
    cut_again,
    cuts_between,
    difference,
    joined_again,
    labels_at,
)
from dshpm_jax._review.said import as_it_was, covered, known_of, only, said_again, stays, superseded
from dshpm_jax._review.saying import cuts_of, effects_of, told, words
from dshpm_jax._types import NO_MATCH


class Stale(Exception):
    """The page asks for something about labels that are others now."""


class Log(Protocol):
    """Where corrections are kept: when `append` returns, the line is on the disk."""

    def append(self, correction: Correction) -> None: ...


Solver = Callable[[Labelling, Sequence[KnownLabel]], Labelling]
"""Solves anew around what is said: takes the labels before it, and all that is known with it."""


@dataclass(eq=False)
class Proposal:
    """A correction that was worked out, and does not count before it is accepted.

    Attributes:
        labelling: with all that it changes.
        mine: with what was said alone.
        others: what it changes besides.
        gone: earlier corrections, by their ids, that are taken back because it says the opposite.
    """

    correction: Correction
    labelling: Labelling
    mine: Labelling
    others: list[Effect]
    gone: list[str]


@dataclass(eq=False)
class Session:
    """A trial in hand.

    Attributes:
        labelling: with all corrections that stand.
        lines: all that was ever done, in order.
        log: where each line is kept.
        solver: works out what else a correction changes; None where nothing but names is known.
        version: counts up with each change.
        kept: is called after each change that is on the disk.
    """

    labelling: Labelling
    log: Log
    lines: list[Correction] = field(default_factory=list)
    solver: Solver | None = None
    version: int = 0
    proposal: Proposal | None = None
    kept: Callable[[], object] = lambda: None
    lock: RLock = field(default_factory=RLock)

    @property
    def standing(self) -> list[Correction]:
        return resolved(self.lines)[0]

    @property
    def undone(self) -> list[Correction]:
        return resolved(self.lines)[1]

    @contextmanager
    def at(self, version: int) -> Iterator[None]:
        """Holds the session still, as long as the page speaks of the labels that it has."""
        with self.lock:
            if version != self.version:
                raise Stale("the labels have changed meanwhile; what you see is now up to date, do it again")
            yield

    def known(self) -> tuple[KnownLabel, ...]:
        """All that persons have said, as it stands."""
        return known_of(self.standing)

    def propose(self, wanted: dict[str, Any]) -> None:
        """Works out what `wanted` does; it counts at once where it changes nothing else, and is proposed if it does.

        Raises:
            ValueError: it cannot be done; the text says why.
        """
        self.proposal = None
        if wanted["kind"] == "cut":
            return self._cut(int(wanted["track"]), int(wanted["frame"]))
        edit = self._edit(wanted)
        kind = "confirm" if wanted["kind"] == "confirm" else "label"
        gone = superseded(self.standing, edit.known)
        known = known_of([*(one for one in self.standing if one.id not in gone), only(edit.known)])
        own = self._own(edit)
        changes = tuple(self._change(known) for known in edit.known)
        solved = None
        if self.solver is not None and kind == "label":
            solved = self.solver(self.labelling, known)
        result = edit.labelling if solved is None else adopted(self.labelling, solved)
        effects = difference(self.labelling, result, own)
        others = [effect for effect in difference(self.labelling, result) if not covered(effect, edit.known)]
        details = {"effects": effects, "cuts": cuts_between(self.labelling, result)}
        correction = Correction(kind, changes, by=_user(), details=details)
        self.proposal = Proposal(correction, result, edit.labelling, others, gone)
        if not others:
            self.accept()
        return None

    def accept(self, mine_only: bool = False) -> None:
        """The proposal counts; with `mine_only`, what else it would have changed is kept as it was, and known to be.

        Raises:
            ValueError: nothing is proposed.
        """
        proposal = self.proposal
        if proposal is None:
            raise ValueError("nothing is proposed")
        correction, labelling = proposal.correction, proposal.labelling
        if mine_only:
            own = self._own(Edit(proposal.mine, tuple(change.known for change in correction.changes)))
            labelling = proposal.mine
            stay = [as_it_was(effect) for effect in proposal.others if stays(effect, proposal.mine)]
            effects = difference(self.labelling, labelling, own)
            details = {"effects": effects, "cuts": cuts_between(self.labelling, labelling)}
            correction = replace(correction, changes=(*correction.changes, *stay), details=details)
        for one in proposal.gone:
            self._note(Correction("undo", of=one, by=_user()))
        self._keep(correction, labelling)

    def refuse(self) -> None:
        """Forgets the proposal."""
        self.proposal = None

    def undo(self) -> None:
        """Takes back the last correction that stands; `ValueError` if there is none."""
        if not self.standing:
            raise ValueError("nothing to undo")
        last = self.standing[-1]
        self._keep(Correction("undo", of=last.id, by=_user()), self._without(last))

    def redo(self) -> None:
        """Does the last one undone again; `ValueError` if there is none."""
        if not self.undone:
            raise ValueError("nothing to do again")
        last = self.undone[-1]
        self._keep(Correction("redo", of=last.id, by=_user()), self._with(last))

    @property
    def confirmed(self) -> bool:
        """Whether a person has said that all labels are right."""
        return any(one.whole for one in self.standing)

    def confirm_all(self) -> None:
        """All labels are right as they are."""
        if self.proposal is not None:
            raise ValueError("accept or refuse first")
        if not self.confirmed:
            self._keep(Correction("confirm", whole=True, by=_user()), self.labelling)

    def fill(self, marker: str, span: Span, accepted: bool) -> None:
        """Accepts a filled gap, or refuses it again."""
        details = {"marker": marker, "first": span.first, "last": span.last, "accepted": accepted}
        self._keep(Correction("fill", by=_user(), details=details), self.labelling)

    def fills(self) -> list[tuple[str, Span]]:
        """The filled gaps that are accepted."""
        found: dict[tuple[str, Span], bool] = {}
        for one in self.standing:
            if one.kind == "fill":
                place = one.details["marker"], Span(one.details["first"], one.details["last"])
                found[place] = one.details["accepted"]
        return [place for place, accepted in found.items() if accepted]

    def told(self) -> dict[str, Any] | None:
        """The proposal as the page shows it."""
        if self.proposal is None:
            return None
        return {"text": words(self.proposal.correction), "others": told(self.proposal.others)}

    def catch_up(self, applied: Sequence[str]) -> None:
        """Brings labels of which only the corrections with the ids `applied` are part up to all that stand.

        Those that are part of them but undone since are taken back first, the last one first.
        """
        made, standing = {one.id: one for one in self.lines}, [one.id for one in self.standing]
        same = next((k for k, (a, b) in enumerate(zip(applied, standing)) if a != b), min(len(applied), len(standing)))
        for gone in reversed(applied[same:]):
            if gone in made:
                self.labelling = self._without(made[gone])
        for due in standing[same:]:
            self.labelling = self._with(made[due])

    def _note(self, correction: Correction) -> None:
        self.log.append(correction)
        self.lines.append(correction)

    def _keep(self, correction: Correction, labelling: Labelling) -> None:
        self._note(correction)
        self.labelling, self.proposal = labelling, None
        self.version += 1
        self.kept()

    def _cut(self, trajectory: int, frame: int) -> None:
        labelling = edits.split(self.labelling, trajectory, frame)
        identity = self.labelling.identity[trajectory]
        label = None if identity == NO_MATCH else self.labelling.model.markers[identity]
        details = {"frame": frame, "label": label, "cuts": cuts_between(self.labelling, labelling)}
        self._keep(Correction("cut", by=_user(), details=details), labelling)

    def _without(self, correction: Correction) -> Labelling:
        return joined_again(after(self.labelling, effects_of(correction), back=True), cuts_of(correction))

    def _with(self, correction: Correction) -> Labelling:
        if correction.changes and "effects" not in correction.details:  # made by another program
            return said_again(self.labelling, correction.changes)
        return after(cut_again(self.labelling, cuts_of(correction)), effects_of(correction))

    def _edit(self, wanted: dict[str, Any]) -> Edit:
        kind, labelling = wanted["kind"], self.labelling
        if kind == "exchange":
            one, other = (self._marker(wanted[name]) for name in ("one", "other"))
            return edits.exchange(labelling, one, other, _span(wanted))
        trajectory = self._trajectory(wanted["track"])
        if kind == "merge":
            return edits.merge(labelling, trajectory, self._trajectory(wanted["with"]))
        if kind == "confirm":
            whole = edits.whole(labelling, trajectory)
            return edits.assign(labelling, trajectory, whole, int(labelling.identity[trajectory]))
        if kind == "assign":
            marker = NO_MATCH if wanted["label"] is None else self._marker(wanted["label"])
            return edits.assign(labelling, trajectory, _span(wanted), marker)
        raise ValueError(f"nobody knows how to {kind}")

    def _trajectory(self, number: Any) -> int:
        if not isinstance(number, int) or not 0 <= number < len(self.labelling.trajectories):
            raise ValueError("there is no such trajectory")
        return number

    def _marker(self, name: Any) -> int:
        if name not in self.labelling.model.markers:
            raise ValueError(f"{name}: no marker of this trial has that name")
        return self.labelling.model.markers.index(name)

    def _own(self, edit: Edit) -> np.ndarray:
        own = np.zeros(self.labelling.trajectories.index.shape, bool)
        columns = np.asarray(self.labelling.recording.columns)[self.labelling.trajectories.column]
        for known in edit.known:
            some = slice(known.first, known.last)
            own[some] |= columns[some] == known.column
        return own & (self.labelling.trajectories.index != NO_MATCH)

    def _change(self, known: KnownLabel) -> Change:
        """With the label that most of its points had."""
        tracks, some = self.labelling.trajectories, slice(known.first, known.last)
        here = tracks.column[some] == self.labelling.recording.columns.index(known.column)
        labels, counts = np.unique(labels_at(self.labelling)[some][here], return_counts=True)
        was = int(labels[counts.argmax()]) if len(labels) else NO_MATCH
        name = None if was == NO_MATCH else self.labelling.model.markers[was]
        last = tracks.num_frames if known.last is None else known.last
        return Change(known.column, known.first, last, known.label, name)


def _span(wanted: dict[str, Any]) -> Span:
    first, last = wanted["first"], wanted["last"]
    if not (isinstance(first, int) and isinstance(last, int) and 0 <= first < last):
        raise ValueError("a span ends after its first frame")
    return Span(first, last)


def _user() -> str | None:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a container without names
        return None
