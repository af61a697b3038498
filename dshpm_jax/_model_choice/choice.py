"""What a model is made of: labelled recordings of one body, that move, and that agree about the labels."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from dshpm_jax._model_building import TUNING, gather, liveliness
from dshpm_jax._model_choice.folders import FolderContents, find
from dshpm_jax._model_choice.wrong_labels import find_wrong_labels
from dshpm_jax._reading import AS_USUAL, Reading
from dshpm_jax._recording import Recording

SHARED = 3
"""count; used in `_of_one_body`: recordings that share fewer markers are of different bodies; by hand: fewer markers
fix no place in space."""

SHOWN = 5  # names in a line about many files or markers


@dataclass
class Choice:
    """The recordings of one folder, used or not.

    Attributes:
        folder: where they are.
        used: what the model is to be made of, in the order of the names of the files.
        notes: what is to be said about some that are used.
        left_out: the labelled or unreadable others, and why they are not used.
        unlabelled: recordings without a label.
    """

    folder: Path
    used: list[Recording]
    notes: dict[Path, str] = field(default_factory=dict)
    left_out: dict[Path, str] = field(default_factory=dict)
    unlabelled: list[Path] = field(default_factory=list)

    def lines(self) -> Iterator[str]:
        """For people: a line for each recording, and one for all that have no label."""
        for path in map(_path, self.used):
            yield f"{path}: used{f', {self.notes[path]}' if path in self.notes else ''}"
        for path, why in self.left_out.items():
            yield f"{path}: not used, {why}"
        if self.unlabelled:
            count = f"{len(self.unlabelled)} recordings have" if len(self.unlabelled) > 1 else "1 recording has"
            yield f"{self.folder}: {count} no label: {_some([path.name for path in self.unlabelled])}"


def choose(folder: Path, how: Reading = AS_USUAL) -> Choice:
    """Chooses among the recordings that a folder holds directly; `how` they are read is as for `io.read`.

    Left out are results of this program, files that cannot be read, recordings without a label or of another body, and
    those that hardly move beside livelier ones and add no marker. Labels are not compared (`compare_labels`).
    """
    found: FolderContents = find(folder, how)
    choice = Choice(folder, found.labelled, left_out=found.left_out, unlabelled=found.unlabelled)
    _of_one_body(choice)
    _lively(choice)
    return choice


def compare_labels(choice: Choice) -> None:
    """Leaves out recordings whose labels the model of the others contradicts, or says that two contradict each other.

    This takes by far the longest: each recording is checked against a model of others.
    """
    verdict = find_wrong_labels(choice.used)
    paths = [_path(r) for r in choice.used]
    for k, what in verdict.undecided.items():
        others = _some([paths[i].name for i in verdict.kept if i != k])
        choice.notes[paths[k]] = f"but the model of {others} says: {what}; look which of them is right"
    _leave_out(choice, {paths[k]: f"the model of the others says: {what}" for k, what in verdict.wrong.items()})


def _of_one_body(choice: Choice) -> None:
    """Keeps the most recordings that share markers, and of as many those with the most points."""
    groups: list[tuple[set[str], list[Recording]]] = []
    for recording in choice.used:
        names = _names(recording)
        near = [group for group in groups if len(group[0] & names) >= min(SHARED, len(names))]
        groups = [group for group in groups if group not in near]
        groups.append((names.union(*(g[0] for g in near)), [r for g in near for r in g[1]] + [recording]))
    if len(groups) < 2:
        return
    best = max(groups, key=lambda group: (len(group[1]), sum(int(r.present.sum()) for r in group[1])))
    why = f"shares no markers with {_some([_path(r).name for r in best[1]])}: another body, or other names"
    _leave_out(choice, {_path(r): why for group in groups if group is not best for r in group[1]})


def _lively(choice: Choice) -> None:
    """Leaves out what hardly moves beside the liveliest recording, unless it has markers that no other has."""
    if len(choice.used) < 2:
        return
    moved = {_path(r): liveliness(gather([r])[1][0]) for r in choice.used}
    liveliest = max(moved, key=lambda path: moved[path])
    still = [r for r in choice.used if moved[_path(r)] < TUNING.still_weight * moved[liveliest]]
    known = set().union(*(_names(r) for r in choice.used if r not in still))
    why_not = {}
    for recording in still:
        path = _path(recording)
        what = f"hardly moves ({moved[path]:.0f} mm) beside {liveliest.name} ({moved[liveliest]:.0f} mm)"
        if new := sorted(_names(recording) - known):
            choice.notes[path] = f"though it {what}, for {_some(new)}; it counts little otherwise"
            known.update(new)
        else:
            why_not[path] = f"it {what} and adds no marker"
    _leave_out(choice, why_not)


def _leave_out(choice: Choice, why: dict[Path, str]) -> None:
    choice.left_out |= why
    choice.used = [recording for recording in choice.used if _path(recording) not in why]


def _names(recording: Recording) -> set[str]:
    """Markers that are labelled and seen."""
    columns = np.flatnonzero(recording.labelled & recording.present.any(0))
    return {recording.labels[column] for column in columns}


def _path(recording: Recording) -> Path:
    assert recording.source is not None, "recordings of a folder are read from files"
    return recording.source


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:SHOWN]) + (", ..." if len(names) > SHOWN else "")
