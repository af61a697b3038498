"""What a trajectory may be: labels with the probability of each, for the keys of the page."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from dshpm_jax._control.tuning import TUNING
from dshpm_jax._labelling import Labelling
from dshpm_jax._settings import Settings
from dshpm_jax._types import NO_MATCH

SHOWN = 9
"""count; used in `candidates`: as many as there are keys."""

LEAST = 0.001
"""share; used in `candidates`: a label that is less likely has no key."""

LIKELY_IF_WITHHELD = 0.5
"""probability; used in `candidates`: where nothing but names is known, of labels that the result says it may be."""


class Candidate(NamedTuple):
    """A label that a trajectory may have (None: it is no marker) and how likely that is."""

    label: str | None
    probability: float


def evidence_of(labelling: Labelling, settings: Settings) -> Float[np.ndarray, "trajectories markers"]:
    """How well each label fits each trajectory over its life, given the other labels (nats)."""
    from dshpm_jax._control.full.evidence import evidence_in, mean_over_lives, sample_frames  # jax is slow to start
    from dshpm_jax._control.problem import LabellingProblem
    from dshpm_jax._driver import Driver

    problem = LabellingProblem(labelling.trajectories, labelling.model, settings)

    def control():
        found = yield from evidence_in(problem, labelling.identity, sample_frames(problem))
        return mean_over_lives(problem, found)

    return next(Driver().run([control()]))


def candidates(
    labelling: Labelling, trajectory: int, llr: Float[np.ndarray, "trajectories markers"] | None
) -> list[Candidate]:
    """Labels of a trajectory, the likeliest first, no more than there are keys; "no marker" is among them.

    The label that it has is as likely as the labelling says. The others share the rest by what the labels of the
    recording would be worth with them: where another trajectory has such a label meanwhile, the two are exchanged.

    Arguments:
        llr: see `evidence_of`; without it the labels that the labelling names share alike.
    """
    markers = labelling.model.markers
    present, chance = _present(labelling, trajectory)
    share = _by_evidence(labelling, trajectory, llr) if llr is not None else _by_name(labelling, trajectory)
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


def _by_evidence(labelling: Labelling, trajectory: int, llr: np.ndarray) -> Float[np.ndarray, " markers+1"]:
    """Proportional to the odds of each label by its evidence, less what the trajectory that has it now would lose."""
    own, least = llr[trajectory].astype(float), TUNING.accept_llr
    present = int(labelling.identity[trajectory])
    worth = np.append(own, least)
    for marker, holder in _holders(labelling, trajectory).items():
        if marker != present:
            instead = max(llr[holder, present] if present != NO_MATCH else -np.inf, least)
            worth[marker] += instead - max(llr[holder, marker], least)
    return np.exp(TUNING.confidence_per_nat * (worth - worth.max()))


def _holders(labelling: Labelling, trajectory: int) -> dict[int, int]:
    """The trajectory that has each label longest while this one is seen."""
    tracks = labelling.trajectories
    shared = np.minimum(tracks.stop, tracks.stop[trajectory]) - np.maximum(tracks.start, tracks.start[trajectory])
    named = np.flatnonzero((shared > 0) & (labelling.identity != NO_MATCH))
    order = named[np.argsort(shared[named], kind="stable")]
    return {int(labelling.identity[j]): int(j) for j in order}
