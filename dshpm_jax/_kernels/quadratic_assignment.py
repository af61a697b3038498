"""Points to markers by what pairs of points say of pairs of markers: a quadratic assignment.

The score of a pair of points as a pair of markers depends on the pair of points by a number or two only, such as their
distance. So it stands in a table over nodes of these numbers, and a pair of points is a few nodes with weights. A table
of points x points x markers x markers is never made, and sums over it are products of matrices.

Padded points have weight 0 with all others; padded markers are never free.
"""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from dshpm_jax._types import NO_MATCH

SINKHORN_ROUNDS = 15
"""count; used in `soften`: rows and columns are normalised in turn this often; by hand: they change little after."""

USUAL_PARTNERS = 20.0
"""count; used in `soften`: of more partners the mean of so many counts, as all of them say much the same; by hand."""

LEAST_GAIN = 1e-2
"""nats; used in `climb`: smaller gains are rounding."""

SLACK = 1e-3
"""share; used in `soften`: of a row that always stays unlabelled, so that no row is divided by 0."""


class PairScores(NamedTuple):
    """What pairs of points say of pairs of markers (nats).

    Attributes:
        table: the score of two markers at each node, symmetric in them; on its diagonal what two points of one marker
            cost, the same for all markers.
        node, weight: the nodes of each pair of points, and how much each counts; weight 0 where nothing is known.
        points, markers: which are there.
        unlabelled: what a point without a label scores.
    """

    table: Float[Array, "markers nodes markers"]
    node: Int[Array, "points points corners"]
    weight: Float[Array, "points points corners"]
    points: Bool[Array, " points"]
    markers: Bool[Array, " markers"]
    unlabelled: Float[Array, ""]


class Climbed(NamedTuple):
    """Labellings that no single change betters.

    Attributes:
        labels: of each point, `NO_MATCH` where it has none.
        total: what the labelling scores (nats).
        benefit: what each label says for each point, given those of the others (nats).
    """

    labels: Int[Array, " points"]
    total: Float[Array, ""]
    benefit: Float[Array, "points markers"]


@jax.jit
def climb(scores: PairScores, labels: Int[Array, "problems starts points"], steps: Int[Array, ""]) -> Climbed:
    """Labellings after the best single change, for as long as there is one and for at most `steps` times.

    A change gives a point a label that is free, takes its label away, exchanges the labels of two points, or gives an
    unlabelled point the label of another.
    """
    spread = jax.vmap(_spread_nodes)(scores)
    one = jax.vmap(_climb, in_axes=(None, None, 0, None))
    return jax.vmap(one, in_axes=(0, 0, 0, None))(scores, spread, labels, steps)


@jax.jit
def soften(
    scores: PairScores,
    start: Float[Array, "problems starts points markers"],
    sharpness: Float[Array, "starts steps"],
) -> Float[Array, "problems starts points markers"]:
    """What each label says for each point after graduated assignment: shares of labels, sharper in every step.

    Arguments:
        start: the share of each label that a point has at first.
        sharpness: how much a nat a partner counts, step by step.
    """
    spread = jax.vmap(_spread_nodes)(scores)
    one = jax.vmap(_soften, in_axes=(None, None, 0, 0))
    return jax.vmap(one, in_axes=(0, 0, 0, None))(scores, spread, start, sharpness)


def _spread_nodes(scores: PairScores) -> Float[Array, "points nodes points"]:
    """The weight that each pair of points has at each node."""
    nodes = jnp.arange(scores.table.shape[1], dtype=scores.node.dtype)[None, :, None]
    corners = jnp.moveaxis(scores.node, -1, 0), jnp.moveaxis(scores.weight, -1, 0)
    parts = [jnp.where(node[:, None] == nodes, weight[:, None], 0.0) for node, weight in zip(*corners)]
    return functools.reduce(jnp.add, parts)


def _benefit(scores: PairScores, spread: Array, share: Float[Array, "points markers"]) -> Array:
    """What each label says for each point, where the others have labels by shares."""
    at_nodes = jnp.einsum("ikj,jb->ikb", spread, share)
    return jnp.einsum("ikb,akb->ia", at_nodes, scores.table)


def _soften(scores: PairScores, spread: Array, start: Array, sharpness: Float[Array, " steps"]) -> Array:
    possible = scores.points[:, None] & scores.markers[None]
    there = possible.astype(start.dtype)
    partners = jnp.minimum(scores.points.sum(), scores.markers.sum()).astype(start.dtype)
    many = jnp.maximum(1.0, partners / USUAL_PARTNERS)

    def step(share, sharp):
        benefit = jnp.where(possible, _benefit(scores, spread, share) / many, -jnp.inf)
        top = jnp.maximum(benefit.max(1, keepdims=True), -1e6)
        share = jnp.exp(jnp.maximum(sharp * (benefit - top), -60.0)) * there

        def normalise(share, _):
            share = share / (share.sum(1, keepdims=True) + SLACK)
            return share / jnp.maximum(1.0, share.sum(0, keepdims=True)), None

        return jax.lax.scan(normalise, share, None, length=SINKHORN_ROUNDS)[0], None

    share = jax.lax.scan(step, start * there, sharpness)[0]
    return _benefit(scores, spread, share)


class _Climb(NamedTuple):
    labels: Int[Array, " points"]
    benefit: Float[Array, "points markers"]
    gained: Float[Array, ""]
    step: Int[Array, ""]


def _climb(scores: PairScores, spread: Array, labels: Int[Array, " points"], steps: Int[Array, ""]) -> Climbed:
    markers = jnp.arange(scores.table.shape[0], dtype=labels.dtype)[None]
    benefit = _benefit(scores, spread, (labels[:, None] == markers).astype(scores.table.dtype))
    alike = jnp.einsum("ikj,k->ij", spread, scores.table[0, :, 0])
    gained = jnp.full_like(scores.unlabelled, jnp.inf)
    start = _Climb(labels, benefit, gained, jnp.zeros_like(steps))

    def goes_on(state: _Climb):
        return (state.step < steps) & (state.gained > LEAST_GAIN)

    state = jax.lax.while_loop(goes_on, functools.partial(_best_change, scores, spread, alike), start)
    return Climbed(state.labels, _total(scores, state.labels, state.benefit), state.benefit)


def _total(scores: PairScores, labels: Int[Array, " points"], benefit: Float[Array, "points markers"]):
    """What a labelling scores, each pair once."""
    labelled = labels != NO_MATCH
    own = jnp.take_along_axis(benefit, jnp.maximum(labels, 0)[:, None], 1)[:, 0]
    alone = (scores.points & ~labelled).sum().astype(benefit.dtype)
    return 0.5 * jnp.where(labelled, own, 0.0).sum() + alone * scores.unlabelled


def _said_by(scores: PairScores, spread: Array, point: Array, label: Array) -> Float[Array, "points markers"]:
    """What a point with a label says of each label for each point; nothing without a label."""
    said = spread[:, :, point] @ scores.table[:, :, jnp.maximum(label, 0)].T
    return jnp.where(label == NO_MATCH, 0.0, said)


def _best_change(scores: PairScores, spread: Array, alike: Array, state: _Climb) -> _Climb:
    gain, held_by = _gains(scores, alike, state)
    markers = gain.shape[1] - 1
    best = jnp.argmax(gain).astype(state.labels.dtype)
    point, label = best // (markers + 1), best % (markers + 1)
    gained = gain.ravel()[best]
    before = state.labels[point]
    after = jnp.where(label == markers, NO_MATCH, label)
    loser = jnp.where(label == markers, NO_MATCH, held_by[jnp.minimum(label, markers - 1)])
    lost, safe_loser = loser != NO_MATCH, jnp.maximum(loser, 0)
    changed = state.labels.at[point].set(after)
    changed = jnp.where(lost, changed.at[safe_loser].set(before), changed)
    said = functools.partial(_said_by, scores, spread)
    moved = said(point, after) - said(point, before)
    moved += jnp.where(lost, said(safe_loser, before) - said(safe_loser, after), 0.0)
    go = gained > LEAST_GAIN
    labels = jnp.where(go, changed, state.labels)
    return _Climb(labels, jnp.where(go, state.benefit + moved, state.benefit), gained, state.step + 1)


def _gains(scores: PairScores, alike: Array, state: _Climb) -> tuple[Array, Array]:
    """What each change gains, a label in each column and none in the last; and which point holds each label.

    A point takes a label; whoever holds it takes this point's, or none if it has none.
    """
    labels, benefit = state.labels, state.benefit
    count, markers = benefit.shape
    in_order = jnp.arange(markers, dtype=labels.dtype)[None]
    labelled, safe = labels != NO_MATCH, jnp.maximum(labels, 0)
    own = jnp.where(labelled, jnp.take_along_axis(benefit, safe[:, None], 1)[:, 0], scores.unlabelled)
    held_by = jnp.full(markers + 1, NO_MATCH, labels.dtype)
    held_by = held_by.at[jnp.where(labelled, labels, markers)].set(jnp.arange(count, dtype=labels.dtype))[:markers]
    other, held = jnp.maximum(held_by, 0), held_by != NO_MATCH
    between = _as_pair(scores, safe[:, None], other[None], in_order)
    same, own_of_other = alike[:, other], own[other][None]
    free = benefit - own[:, None]
    exchange = free + benefit[other][:, safe].T - own_of_other - 2.0 * same + 2.0 * between
    take = free - same - own_of_other + scores.unlabelled
    gain = jnp.where(held[None], jnp.where(labelled[:, None], exchange, take), free)
    possible = scores.points[:, None] & scores.markers[None] & (labels[:, None] != in_order)
    drop = jnp.where(labelled, scores.unlabelled - own, -jnp.inf)
    return jnp.concatenate([jnp.where(possible, gain, -jnp.inf), drop[:, None]], axis=1), held_by


def _as_pair(scores: PairScores, label: Array, other: Array, other_label: Array) -> Float[Array, "points markers"]:
    """The score of each point and another one as a pair of markers."""
    point = jnp.arange(len(scores.node), dtype=other.dtype)[:, None]
    node, weight = scores.node[point, other], scores.weight[point, other]
    return (scores.table[label[..., None], node, other_label[..., None]] * weight).sum(-1)
