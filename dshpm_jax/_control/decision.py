"""What is finally given out: labels, how sure each is, and why a trajectory has none."""

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.assignment import margins
from dshpm_jax._control.evidence import ACCEPT
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State
from dshpm_jax._labelling import POOR_FIT, Reason
from dshpm_jax._types import NO_MATCH

BASE, PER_NAT, PER_DECADE = 0.6, 0.75, 1.45
"""Log odds that a label is right: of one second without evidence, for a nat of mean evidence, for ten times as long.

Fitted by logistic regression to real recordings (`bench/reliability.py` shows how far it holds on others). The margin
to the best rival adds nothing to them: exact assignment and moves have weighed the rivals already.
"""

SECONDS = 0.01, 10.0  # lives count as no shorter and no longer
NATS = 6.0, 12.0  # evidence counts down to minus the one and up to the other

RESCALED = 0.86
"""Share of the labels that were right where the model was another subject's and rescaled, over nine pairs of people. A
turned head or trunk fits a model that was made from its own labels, so the evidence does not tell them apart."""

FITTED_BADLY = 0.83
"""Share of the labels that were right, however certain each, in 17 labellings with a `model_fit` under `POOR_FIT`."""

NEAR_TIE = 2.0
"""Nats within which a rival is named as the reason why a label is withheld."""


def decide(scene: Scene, state: State, ceiling: float = 1.0) -> tuple[np.ndarray, np.ndarray, tuple[Reason, ...]]:
    """Identity, confidence and reason of each trajectory.

    The confidence is the probability that the label is right, or that none is. Labels less likely than
    `Settings.min_confidence` are withheld.

    Arguments:
        ceiling: no label is surer than this; see `ceiling_of`.
    """
    named = state.identity != NO_MATCH
    chance = np.minimum(_chance(scene, state), ceiling)
    best = state.evidence.max(1)
    none = _logistic(ACCEPT - best)
    withheld = named & (chance < scene.settings.min_confidence)
    margin = margins(state.identity, state.evidence, scene.trajectories.start, scene.trajectories.stop)
    reason = np.where(best > ACCEPT, Reason.TAKEN, Reason.OUTSIDE)
    reason = np.where(named, Reason.MATCHED, reason)
    reason = np.where(withheld, np.where(margin < NEAR_TIE, Reason.AMBIGUOUS, Reason.DOUBTFUL), reason)
    identity = np.where(withheld, NO_MATCH, state.identity)
    confidence = np.where(withheld, 1.0 - chance, np.where(named, chance, none))
    return identity, confidence, tuple(map(Reason, reason))


def ceiling_of(fit: float) -> float:
    """How sure labels can be at most where the model fits so well, see `model_fit`."""
    return FITTED_BADLY if fit < POOR_FIT else 1.0


def alternatives(state: State, identity: Int[np.ndarray, " trajectories"]) -> Int[np.ndarray, "trajectories 2"]:
    """The label withheld from each trajectory, then the best of the others that would pay; `NO_MATCH` beyond.

    Arguments:
        identity: the labels given out, as `decide` has them.
    """
    evidence = state.evidence.copy()
    named = np.flatnonzero(state.identity != NO_MATCH)
    evidence[named, state.identity[named]] = -np.inf
    other = np.where(evidence.max(1) > ACCEPT, evidence.argmax(1), NO_MATCH)
    kept = identity == state.identity
    first, second = np.where(kept, other, state.identity), np.where(kept, NO_MATCH, other)
    return np.stack([first, second], axis=1).astype(np.int32)


def _chance(scene: Scene, state: State) -> Float[np.ndarray, " trajectories"]:
    """The probability that each label is right; means nothing where there is none."""
    t = scene.trajectories
    own = state.evidence[np.arange(len(t)), np.maximum(state.identity, 0)]
    seconds = np.clip((t.stop - t.start) / t.rate, *SECONDS)
    worth = RESCALED if scene.settings.rescale else 1.0
    return worth * _logistic(BASE + PER_NAT * np.clip(own, -NATS[0], NATS[1]) + PER_DECADE * np.log10(seconds))


def _logistic(log_odds: np.ndarray) -> np.ndarray:
    return 1.0 / (1.0 + np.exp(-np.clip(log_odds, -30.0, 30.0)))
