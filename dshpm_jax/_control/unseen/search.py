"""The best labelling of one moment: starts climb, and the best of them exchange labels, limbs and sides."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.unseen.chains import chains, drops
from dshpm_jax._control.unseen.judge import Judge
from dshpm_jax._control.unseen.starts import assigned
from dshpm_jax._requests import ClimbLabels, Control, PairTable
from dshpm_jax._types import NO_MATCH

CLIMBS = 400
"""count; changes of a climb at most; by hand: they end by themselves."""

CLIMBS_AFTER_EXCHANGE = 12
"""count; used in `_permuted`: changes after limbs were exchanged; by hand: cost."""

ASSIGNMENTS = 6
"""count; used in `climb`: assignments and climbs in turn at most; by hand."""

_Labels = Int[np.ndarray, " points"]


def best_labelling(
    judge: Judge, starts: Sequence[_Labels], permutations: Sequence[Int[np.ndarray, " markers"]]
) -> Control[tuple[_Labels, float]]:
    """The labelling of largest worth that the starts lead to, and its worth.

    Arguments:
        permutations: what each label becomes when limbs or sides are exchanged.
    """
    found = yield from climb(judge.pairs, distinct(starts))
    found = np.stack(distinct(list(found)))
    values = yield from judge.values(found)
    best, most = found[0], -np.inf
    for k in np.argsort(-values, kind="stable")[: judge.tuning.starts_kept]:
        labels, value = yield from _exchanged(judge, found[k], float(values[k]), permutations)
        if value > most:
            best, most = labels, value
    for _ in range(judge.tuning.exchange_rounds):
        labels, value = best, most
        for propose in (_chained, _dropped, _rebuilt):
            labels, value = yield from _best_of(judge, labels, value, (yield from propose(judge, labels)))
        if value == most:
            break
        best, most = yield from _exchanged(judge, labels, value, permutations)
    return best, most


def distinct(labellings: Sequence[_Labels]) -> list[_Labels]:
    """Each labelling once, in their order."""
    return list({one.tobytes(): one for one in labellings}.values())


def climb(pairs: PairTable, starts: Sequence[_Labels]) -> Control[Int[np.ndarray, "starts points"]]:
    """Labellings that neither a single change nor a new assignment betters, by pairs alone."""
    found = yield ClimbLabels(pairs, np.stack(starts), CLIMBS)
    labels, total, benefit = found.labels.copy(), found.total.copy(), found.benefit.copy()
    open_ = np.arange(len(labels))
    for _ in range(ASSIGNMENTS):
        again = np.stack([assigned(benefit[k], pairs.unlabelled) for k in open_])
        changed = (again != labels[open_]).any(1)
        open_ = open_[changed]
        if not len(open_):
            break
        found = yield ClimbLabels(pairs, again[changed], CLIMBS)
        better = found.total > total[open_] + 1e-3
        open_ = open_[better]
        labels[open_], total[open_], benefit[open_] = (x[better] for x in (found.labels, found.total, found.benefit))
        if not len(open_):
            break
    return labels


def _exchanged(
    judge: Judge, labels: _Labels, value: float, permutations: Sequence[np.ndarray]
) -> Control[tuple[_Labels, float]]:
    """The labelling after exchanges of labels and limbs, for as long as they pay by pairs and volumes together."""
    for _ in range(judge.tuning.exchange_rounds):
        before = value
        labels, value = yield from _best_of(judge, labels, value, (yield from _permuted(judge, labels, permutations)))
        labels, value = yield from _best_of(judge, labels, value, (yield from _swapped(judge, labels)))
        if value == before:
            break
    return labels, value


def near_labellings(
    judge: Judge, labels: _Labels, permutations: Sequence[Int[np.ndarray, " markers"]]
) -> Control[Int[np.ndarray, "others points"]]:
    """The labellings that come nearest to one by exchanges, permutations and chains."""
    found = [
        (yield from _swapped(judge, labels)),
        _renamed(labels, permutations),
        (yield from _chained(judge, labels)),
    ]
    others = [one for one in distinct(list(np.concatenate(found))) if (one != labels).any()]
    return np.stack(others) if others else np.zeros((0, len(labels)), int)


def _best_of(
    judge: Judge, labels: _Labels, value: float, proposals: Int[np.ndarray, "proposals points"]
) -> Control[tuple[_Labels, float]]:
    """The best of the proposals if it is clearly better than the labelling, else that."""
    if not len(proposals):
        return labels, value
    values = yield from judge.values(proposals)
    k = int(np.argmax(values))
    if values[k] > value + judge.tuning.min_exchange_gain:
        return proposals[k], float(values[k])
    return labels, value


def _permuted(
    judge: Judge, labels: _Labels, permutations: Sequence[np.ndarray]
) -> Control[Int[np.ndarray, "proposals points"]]:
    """The labelling after each permutation, and the most promising of them after a climb."""
    proposals = _renamed(labels, permutations)
    if not len(proposals):
        return proposals
    values = yield from judge.values(proposals)
    best = proposals[np.argsort(-values, kind="stable")[: judge.tuning.permutations_climbed]]
    climbed = yield ClimbLabels(judge.pairs, best, CLIMBS_AFTER_EXCHANGE)
    return np.concatenate([proposals, climbed.labels])


def _chained(judge: Judge, labels: _Labels) -> Control[Int[np.ndarray, "proposals points"]]:
    """The labelling after chains of labels, each as it is."""
    judged = yield ClimbLabels(judge.pairs, labels[None], 0)
    found = distinct(list(chains(labels, judged.benefit[0], judge.pairs.unlabelled)))
    return np.stack(found) if found else np.zeros((0, len(labels)), int)


def _dropped(judge: Judge, labels: _Labels) -> Control[Int[np.ndarray, "proposals points"]]:
    """The labelling without the labels that pairs and volumes are against."""
    labelled = np.flatnonzero(labels != NO_MATCH)
    if not len(labelled):
        return np.zeros((0, len(labels)), int)
    single = np.repeat(labels[None], len(labelled), axis=0)
    single[np.arange(len(labelled)), labelled] = NO_MATCH
    return np.stack(list(drops(labels, (yield from judge.values(single)))))


def _rebuilt(judge: Judge, labels: _Labels) -> Control[Int[np.ndarray, "proposals points"]]:
    """The labelling with the labels around each marker given anew: no single change leads out of a shift by one."""
    near = judge.handed.near
    sets = [row[:count] for count in (near.shape[1] // 2, near.shape[1]) for row in near]
    bare = [np.where(np.isin(labels, some), NO_MATCH, labels) for some in sets]
    bare = [one for one in distinct(bare) if (one != labels).any()]
    if not bare:
        return np.zeros((0, len(labels)), int)
    judged = yield ClimbLabels(judge.pairs, np.stack(bare), 0)
    filled = [_filled(judge, *each) for each in zip(judged.labels, judged.benefit, strict=True)]
    filled = [one for one in distinct(filled) if (one != labels).any()]
    if not filled:
        return np.zeros((0, len(labels)), int)
    climbed = yield ClimbLabels(judge.pairs, np.stack(filled), CLIMBS_AFTER_EXCHANGE)
    return climbed.labels


def _filled(judge: Judge, labels: _Labels, benefit: Float[np.ndarray, "points markers"]) -> _Labels:
    """The labelling with free labels given to points without one, by what the labelled ones say."""
    points, free = np.flatnonzero(labels == NO_MATCH), np.setdiff1d(np.arange(benefit.shape[1]), labels)
    given = assigned(benefit[np.ix_(points, free)], judge.pairs.unlabelled)
    labels = labels.copy()
    labels[points] = np.where(given == NO_MATCH, NO_MATCH, free[np.maximum(given, 0)]) if len(free) else NO_MATCH
    return labels


def _renamed(labels: _Labels, permutations: Sequence[np.ndarray]) -> Int[np.ndarray, "proposals points"]:
    """The labelling after each permutation of its labels that changes it."""
    changed = [np.where(labels == NO_MATCH, NO_MATCH, to[np.maximum(labels, 0)]) for to in permutations]
    changed = [one for one in distinct(changed) if (one != labels).any()]
    return np.stack(changed) if changed else np.zeros((0, len(labels)), int)


def _swapped(judge: Judge, labels: _Labels) -> Control[Int[np.ndarray, "proposals points"]]:
    """The labelling with two labels exchanged, the most promising by pairs."""
    judged = yield ClimbLabels(judge.pairs, labels[None], 0)
    labelled = np.flatnonzero(labels != NO_MATCH)
    one, other = np.triu_indices(len(labelled), 1)
    gain = swap_gains(judge.pairs, labels, judged.benefit[0])[one, other]
    proposals = []
    for k in np.argsort(-gain, kind="stable")[: judge.tuning.exchanges_tried]:
        changed = labels.copy()
        i, j = labelled[one[k]], labelled[other[k]]
        changed[i], changed[j] = labels[j], labels[i]
        proposals.append(changed)
    return np.stack(proposals) if proposals else np.zeros((0, len(labels)), int)


def swap_gains(
    pairs: PairTable, labels: _Labels, benefit: Float[np.ndarray, "points markers"]
) -> Float[np.ndarray, "labelled labelled"]:
    """What pairs gain if two labelled points exchange their labels (nats)."""
    labelled = np.flatnonzero(labels != NO_MATCH)
    own = labels[labelled]
    across = benefit[labelled][:, own]
    now = np.diagonal(across)
    some = np.ix_(labelled, labelled)
    node, weight = pairs.node[some], pairs.weight[some]
    between = (pairs.table[own[:, None, None], node, own[None, :, None]] * weight).sum(-1)
    alike = (pairs.table[own[:, None, None], node, own[:, None, None]] * weight).sum(-1)
    return across + across.T - now[:, None] - now - alike - alike.T + 2.0 * between
