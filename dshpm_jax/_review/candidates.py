"""What a trajectory may be: labels with the probability of each, for the keys of the page."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.tuning import TUNING
from dshpm_jax._labelling import Labelling
from dshpm_jax._requests import Control
from dshpm_jax._settings import Settings
from dshpm_jax._types import NO_MATCH

SHOWN = 9
"""count; used in `candidates`: as many as there are keys."""

LEAST = 1e-4
"""share; used in `candidates`: a label that is less likely has no key."""

MOST_LIMBS = 12
"""count; used in `Evidence.as_others`: exchanges of limbs that are tried; each takes some hundredths of a second."""

LIKELY_IF_WITHHELD = 0.5
"""probability; used in `candidates`: where nothing but names is known, of labels that the result says it may be."""


class Candidate(NamedTuple):
    """A label that a trajectory may have (None: it is no marker) and how likely that is."""

    label: str | None
    probability: float


class Evidence:
    """How well labels fit trajectories over their lives, given the other labels of a labelling (nats).

    Attributes:
        llr: of each label for each trajectory.
    """

    def __init__(self, labelling: Labelling, settings: Settings):
        from dshpm_jax._control.problem import LabellingProblem  # jax is slow to start

        self._labelling = labelling
        self._problem = LabellingProblem(labelling.trajectories, labelling.model, settings)
        self.llr = self._given(labelling.identity)
        self._gains: dict[bytes, Float[np.ndarray, " trajectories"]] = {}

    def as_others(self, trajectory: int, label: int) -> Iterator[tuple[int, float]]:
        """What `label` becomes where a limb is exchanged with its counterpart, and what the mean label of these limbs
        gains while the trajectory is seen (nats)."""
        if label == NO_MATCH:
            return
        tracks, identity = self._labelling.trajectories, self._labelling.identity
        shared = np.minimum(tracks.stop, tracks.stop[trajectory]) - np.maximum(tracks.start, tracks.start[trajectory])
        moving = [to for to in self._problem.prepared.side_permutations if to[label] != label]
        for to in moving[:MOST_LIMBS]:
            involved = np.flatnonzero((identity != NO_MATCH) & (to[identity] != identity) & (shared > 0))
            if len(involved):
                yield int(to[label]), float(np.average(self._gain(to)[involved], weights=shared[involved]))

    def _gain(self, to: Int[np.ndarray, " markers"]) -> Float[np.ndarray, " trajectories"]:
        if to.tobytes() not in self._gains:
            identity = self._labelling.identity
            then = np.where(identity != NO_MATCH, to[identity], NO_MATCH)
            which = np.arange(len(identity))
            self._gains[to.tobytes()] = self._given(then)[which, then] - self.llr[which, identity]
        return self._gains[to.tobytes()]

    def _given(self, identity: Int[np.ndarray, " trajectories"]) -> Float[np.ndarray, "trajectories markers"]:
        from dshpm_jax._control.full.evidence import evidence_in, mean_over_lives, sample_frames
        from dshpm_jax._driver import Driver

        problem = self._problem

        def control() -> Control[Float[np.ndarray, "trajectories markers"]]:
            found = yield from evidence_in(problem, identity, sample_frames(problem))
            return mean_over_lives(problem, found)

        return next(Driver().run([control()]))


def candidates(labelling: Labelling, trajectory: int, evidence: Evidence | None) -> list[Candidate]:
    """Labels of a trajectory, the likeliest first, no more than there are keys; "no marker" is among them.

    The label that it has is as likely as the labelling says. The others share the rest by what the labels of the
    recording would be worth with them: where another trajectory has such a label meanwhile, the two are exchanged, or
    their whole limbs.

    Arguments:
        evidence: without it the labels that the labelling names share alike.
    """
    markers = labelling.model.markers
    present, chance = _present(labelling, trajectory)
    named = evidence is None
    share = _by_name(labelling, trajectory) if named else _by_evidence(labelling, trajectory, evidence)
    number = len(markers) if present == NO_MATCH else present  # "no marker" comes last
    rest = np.delete(share, number)
    share = share * (1 - chance) / max(rest.sum(), 1e-12)
    share[number] = chance
    order = [int(k) for k in np.argsort(-share, kind="stable") if share[k] >= LEAST][:SHOWN]
    return [Candidate(None if k == len(markers) else markers[k], round(float(share[k]), 4)) for k in order]


def _present(labelling: Labelling, trajectory: int) -> tuple[int, float]:
    """What the labelling says of it, and how likely that is: the label withheld where one is."""
    identity, sure = int(labelling.identity[trajectory]), float(labelling.confidence[trajectory])
    withheld = NO_MATCH if labelling.could_be is None else int(labelling.could_be[trajectory, 0])
    if identity == NO_MATCH and withheld != NO_MATCH:
        return withheld, 1 - sure
    return identity, sure


def _by_name(labelling: Labelling, trajectory: int) -> Float[np.ndarray, " markers+1"]:
    share = np.full(labelling.model.num_markers + 1, 1e-9)
    named = () if labelling.could_be is None else labelling.could_be[trajectory]
    for marker in named:
        if marker != NO_MATCH:
            share[marker] = LIKELY_IF_WITHHELD
    share[-1] = max(share[-1], 1 - LIKELY_IF_WITHHELD)
    return share


def _by_evidence(labelling: Labelling, trajectory: int, evidence: Evidence) -> Float[np.ndarray, " markers+1"]:
    """Proportional to the odds of each label by its evidence, less what the trajectory that has it now would lose."""
    llr, least = evidence.llr, TUNING.accept_llr
    own = llr[trajectory].astype(float)
    present = int(labelling.identity[trajectory])
    worth = np.append(own, least)
    for marker, holder in _holders(labelling, trajectory).items():
        if marker != present:
            instead = max(llr[holder, present] if present != NO_MATCH else -np.inf, least)
            worth[marker] += instead - max(llr[holder, marker], least)
    for marker, gain in evidence.as_others(trajectory, present):
        worth[marker] = max(worth[marker], own[present] + gain)
    return np.exp(TUNING.confidence_per_nat * (worth - worth.max()))


def _holders(labelling: Labelling, trajectory: int) -> dict[int, int]:
    """The trajectory that has each label longest while this one is seen."""
    tracks = labelling.trajectories
    shared = np.minimum(tracks.stop, tracks.stop[trajectory]) - np.maximum(tracks.start, tracks.start[trajectory])
    named = np.flatnonzero((shared > 0) & (labelling.identity != NO_MATCH))
    order = named[np.argsort(shared[named], kind="stable")]
    return {int(labelling.identity[j]): int(j) for j in order}
