"""What is finally given out: labels, how sure each is, and why a trajectory has none."""

import numpy as np

from dshpm_jax._control.assignment import margins
from dshpm_jax._control.evidence import ACCEPT
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State
from dshpm_jax._labelling import Reason
from dshpm_jax._types import NO_MATCH

MIN_MARGIN = -3.0
"""A label is withheld if a rival beats it by more nats than this in the evidence of single trajectories. The posture of
the whole body, which that evidence does not see, decides many near ties rightly, so a tie alone is no reason."""


def decide(scene: Scene, state: State) -> tuple[np.ndarray, np.ndarray, tuple[Reason, ...]]:
    """Identity, confidence and reason of each trajectory.

    The confidence is the logistic function of the smaller of two margins: to the best rival, and to being no marker.
    """
    t = scene.trajectories
    margin = margins(state.identity, state.evidence, t.start, t.stop)
    named = state.identity != NO_MATCH
    own = state.evidence[np.arange(len(t)), np.maximum(state.identity, 0)]
    best = state.evidence.max(1)
    sure = np.where(named, np.minimum(margin, own), ACCEPT - best)
    confidence = 1.0 / (1.0 + np.exp(-np.clip(sure, -30.0, 30.0)))
    ambiguous = named & (margin < MIN_MARGIN)
    identity = np.where(ambiguous, NO_MATCH, state.identity)
    reason = tuple(
        Reason.AMBIGUOUS if a else Reason.MATCHED if n else Reason.TAKEN if b > ACCEPT else Reason.OUTSIDE
        for a, n, b in zip(ambiguous, named, best)
    )
    return identity, confidence, reason
