"""How sure a label can be where the population hardly tells it from another, such as two wrist markers."""

from dataclasses import replace

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.full.confidence import FinalLabels
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.unseen.margins import Margins
from dshpm_jax._labelling import Reason
from dshpm_jax._marker_set.tuning import SetTuning
from dshpm_jax._types import NO_MATCH


def as_clear_as_the_population(
    problem: LabellingProblem,
    final: FinalLabels,
    labels: Int[np.ndarray, " trajectories"],
    margins: Margins,
    tuning: SetTuning,
) -> FinalLabels:
    """The labels with no more confidence than the population gives them; what falls short stays open, with both names.

    Arguments:
        labels: what each trajectory would be, also where its label is withheld.
    """
    log_odds = tuning.clear_base + tuning.clear_per_nat * np.nan_to_num(margins.nats, nan=np.inf)
    chance = 1.0 / (1.0 + np.exp(-np.clip(log_odds, -30.0, 30.0)))
    named = (final.identity != NO_MATCH) & ~problem.fixed.given
    most = np.where(named, chance[np.maximum(labels, 0)], 1.0)
    confidence = np.where(named, np.minimum(final.confidence, most), final.confidence)
    open_ = np.flatnonzero(named & (confidence < problem.settings.min_confidence))
    if not len(open_):
        return replace(final, confidence=confidence)
    identity, could_be, reason = final.identity.copy(), final.could_be.copy(), list(final.reason)
    identity[open_] = NO_MATCH
    confidence[open_] = 1.0 - confidence[open_]
    could_be[open_] = np.stack([labels[open_], margins.rival[labels[open_]]], axis=1)
    for j in open_:
        reason[j] = Reason.AMBIGUOUS
    return replace(final, identity=identity, confidence=confidence, could_be=could_be, reason=tuple(reason))
