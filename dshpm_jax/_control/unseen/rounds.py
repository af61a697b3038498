"""Labels and the subject's own distances in turn, over all moments together; the population judges every turn."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.full.assignment import assign_labels
from dshpm_jax._control.unseen.judge import Handed, Judge
from dshpm_jax._control.unseen.margins import Margins, margins_of, together
from dshpm_jax._control.unseen.moments import Moment
from dshpm_jax._control.unseen.search import best_labelling
from dshpm_jax._control.unseen.starts import shape_starts, soft_starts
from dshpm_jax._control.unseen.tables import pair_table, score_table
from dshpm_jax._marker_set.marker_set import MarkerSet
from dshpm_jax._marker_set.posterior import Posterior, posterior_of, prior_of
from dshpm_jax._marker_set.tuning import SetTuning
from dshpm_jax._requests import ClimbLabels, Control, Gather
from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True, eq=False)
class Seen:
    """A moment of one of the recordings of a subject."""

    recording: int
    moment: Moment


@dataclass(frozen=True, eq=False)
class Answered:
    """What was found at one moment.

    Attributes:
        labels: of each point.
        worth: what they are worth by the population (nats).
        strength: what each says for its point, a partner (nats).
    """

    labels: Int[np.ndarray, " points"]
    worth: float
    strength: Float[np.ndarray, " points"]


@dataclass(frozen=True, eq=False)
class PopulationLabels:
    """What the population says of the recordings of a subject.

    Attributes:
        identity: for each recording the marker of each trajectory, `NO_MATCH` where none is found.
        agreement: for each recording the share of the votes of moments that went to the label of each trajectory.
        known: what is known of the subject's distances.
        margins: how clear each label is.
        seen, answered: the moments, and what was found at each.
    """

    identity: list[Int[np.ndarray, " trajectories"]]
    agreement: list[Float[np.ndarray, " trajectories"]]
    known: Posterior
    margins: Margins
    seen: list[Seen]
    answered: list[Answered]


def population_labels(
    markers: MarkerSet,
    recordings: Sequence[Trajectories],
    seen: Sequence[Seen],
    permutations: Sequence[Int[np.ndarray, " markers"]],
    tuning: SetTuning,
    member: Posterior | None = None,
) -> Control[PopulationLabels]:
    """The labels of all recordings of one subject.

    Arguments:
        seen: the moments that are looked at.
        permutations: what each label becomes when limbs or sides are exchanged.
        member: what is known of the subject's distances, if anything is.
    """
    handed, known = Handed.of(markers, tuning), prior_of(markers, tuning) if member is None else member
    table = score_table(markers, known, tuning)
    first = [Judge(one.moment, pair_table(one.moment, table, tuning), handed, tuning) for one in seen]
    answered: list[Answered] = yield Gather(tuple(_first(judge, known, permutations) for judge in first))
    for turn in range(tuning.max_rounds if member is None else 1):
        known = posterior_of(markers, observed(markers, seen, answered, tuning), tuning)
        table = score_table(markers, known, tuning)
        own = [Judge(one.moment, pair_table(one.moment, table, tuning), handed, tuning) for one in seen]
        votes = _identities(markers, recordings, seen, answered)[0]
        starts = [votes[one.recording][one.moment.alive] for one in seen]
        turns = [_again(*each, permutations, turn == 0) for each in zip(first, own, answered, starts)]
        before, answered = answered, (yield Gather(tuple(turns)))
        if all((a.labels == b.labels).all() for a, b in zip(before, answered)):
            break
    known = posterior_of(markers, observed(markers, seen, answered, tuning), tuning)
    identity, agreement = _identities(markers, recordings, seen, answered)
    table = score_table(markers, known, tuning)
    last = [Judge(one.moment, pair_table(one.moment, table, tuning), handed, tuning) for one in seen]
    clear = yield Gather(tuple(margins_of(j, a.labels, permutations) for j, a in zip(last, answered, strict=True)))
    return PopulationLabels(identity, agreement, known, together(clear), list(seen), answered)


def _first(judge: Judge, known: Posterior, permutations: Sequence[np.ndarray]) -> Control[Answered]:
    """What a moment says before anything is known of the subject."""
    starts = yield from soft_starts(judge.pairs)
    starts += shape_starts(judge.moment, known.mean)
    labels, worth = yield from best_labelling(judge, starts, permutations)
    return (yield from _answered(judge, labels, worth))


def _again(
    first: Judge, own: Judge, before: Answered, voted: np.ndarray, permutations: Sequence[np.ndarray], afresh: bool
) -> Control[Answered]:
    """What a moment says by the subject's own distances, unless the population says less for it."""
    starts = [before.labels, _once(voted)]
    if afresh:
        starts += yield from soft_starts(own.pairs)
    labels, _ = yield from best_labelling(own, starts, permutations)
    worth = float((yield from first.values(labels[None]))[0])
    if worth < before.worth:
        labels, worth = before.labels, before.worth
    return (yield from _answered(own, labels, worth))


def _once(labels: np.ndarray) -> np.ndarray:
    """The labels, each for the first point that has it."""
    found = np.full(len(labels), NO_MATCH)
    _, place = np.unique(labels, return_index=True)
    found[place] = labels[place]
    return found


def _answered(judge: Judge, labels: np.ndarray, worth: float) -> Control[Answered]:
    judged = yield ClimbLabels(judge.pairs, labels[None], 0)
    labelled = labels != NO_MATCH
    own = judged.benefit[0][np.arange(len(labels)), np.maximum(labels, 0)]
    strength = np.where(labelled, own / max(1, labelled.sum() - 1), 0.0)
    return Answered(labels, worth, strength)


def observed(
    markers: MarkerSet, seen: Sequence[Seen], answered: Sequence[Answered], tuning: SetTuning
) -> Float[np.ndarray, "markers markers"]:
    """Log mean distances of pairs with labels that can be trusted, over all moments; NaN for others."""
    shape = (markers.num_markers,) * 2
    total, weight = np.zeros(shape), np.zeros(shape)
    for one, answer, share in zip(seen, answered, _shares(answered), strict=True):
        strength, labels = answer.strength, answer.labels
        labelled = np.flatnonzero(labels != NO_MATCH)
        if not len(labelled):
            continue
        least = max(tuning.trusted_llr, tuning.trusted_share * float(np.median(strength[labelled])))
        trusted = labelled[strength[labelled] > least]
        some, own = np.ix_(trusted, trusted), np.ix_(labels[trusted], labels[trusted])
        known = np.isfinite(one.moment.mean[some])
        log = np.log(np.maximum(np.where(known, one.moment.mean[some], 1.0), 1.0))
        counts = np.where(known, one.moment.count[some] * share, 0.0)
        total[own] += counts * log
        weight[own] += counts
    np.fill_diagonal(weight, 0.0)
    return np.where(weight > 0, total / np.maximum(weight, 1e-9), np.nan)


def _shares(answered: Sequence[Answered]) -> Float[np.ndarray, " moments"]:
    """How far each moment is believed, against the one whose labels are worth most each."""
    worth = [max(0.0, one.worth) / max(1, (one.labels != NO_MATCH).sum()) for one in answered]
    return (np.array(worth) / max(max(worth, default=0.0), 1e-9)) ** 2


def _identities(
    markers: MarkerSet, recordings: Sequence[Trajectories], seen: Sequence[Seen], answered: Sequence[Answered]
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """The labels with the most votes of moments, and which share of the votes these are."""
    votes = [np.zeros((len(t), markers.num_markers)) for t in recordings]
    for one, answer, share in zip(seen, answered, _shares(answered), strict=True):
        labelled = np.flatnonzero(answer.labels != NO_MATCH)
        said = np.maximum(answer.strength[labelled], LEAST_VOTE) * max(share, LEAST_VOTE)
        votes[one.recording][one.moment.alive[labelled], answer.labels[labelled]] += said
    identity = [assign_labels(vote, t.start, t.stop) for vote, t in zip(votes, recordings, strict=True)]
    total = [np.maximum(vote.sum(1), 1e-9) for vote in votes]
    won = [vote[np.arange(len(vote)), np.maximum(own, 0)] for vote, own in zip(votes, identity, strict=True)]
    return identity, [w / t for w, t in zip(won, total, strict=True)]


LEAST_VOTE = 0.02
"""nats a partner; used in `_identities`: a label that says less still counts as this."""
