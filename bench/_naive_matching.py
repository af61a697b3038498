"""The iterative match as one would first write it in JAX: a loop for one hypothesis, mapped over all of them."""

import jax
import jax.numpy as jnp
import numpy as np
from _numpy_matching import tables

from dshpm_jax._requests import MatchSegment
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH

BUCKET = 1024  # hypotheses are padded to a multiple of this


def prepared(asked: MatchSegment) -> tuple:
    """The tables and first matches of the hypotheses that survive, padded by matches of nothing, and the problem."""
    _, table, start = tables(asked)
    extra = -len(start) % BUCKET
    pad = ((0, extra), (0, 0))
    table = np.pad(table, (*pad, (0, 0)), constant_values=NO_MATCH).astype(np.int32)
    start = np.pad(start, pad, constant_values=NO_MATCH).astype(np.int32)
    problem = (asked.points - asked.points.mean(0), asked.target.shape, asked.target.scale)
    return table, start, *(np.asarray(x, np.float32) for x in problem)


@jax.jit
def iterate(table, start, points, shape, scale):
    """Assigned points of each hypothesis: all wait for the one that takes the most fits."""
    return jax.vmap(_iterate_one, in_axes=(0, 0, None, None, None))(table, start, points, shape, scale)


def _iterate_one(table, start, points, shape, scale):
    def relative_residuals(assigned):
        there = assigned != NO_MATCH
        weight = (there / jnp.maximum(there.sum(), 1)).astype(points.dtype)[:, None]
        data = points[assigned]
        model_mean, data_mean = (weight * shape).sum(0), (weight * data).sum(0)
        u, _, vt = jnp.linalg.svd((weight * (data - data_mean)).T @ (shape - model_mean))
        u = u.at[:, 2].multiply(jnp.sign(jnp.linalg.det(u @ vt)))
        off = (shape - model_mean) @ (u @ vt).T + data_mean - data
        return there, jnp.where(there, jnp.sqrt((off**2).sum(1)) / scale, -1.0)

    def going(state):
        assigned, _ = state
        there, relative = relative_residuals(assigned)
        count = there.sum()
        return (count > MIN_FIT_POINTS) & (jnp.where(there, relative, 0).sum() >= count)

    def replace_worst(state):
        assigned, tried = state
        worst = relative_residuals(assigned)[1].argmax()
        candidates = table[worst]
        rank = jnp.arange(len(candidates))
        taken = (candidates[:, None] == assigned[None]).any(1)
        usable = (rank >= tried[worst]) & (candidates != NO_MATCH) & ~taken
        choice = jnp.where(usable.any(), candidates[usable.argmax()], NO_MATCH)
        used = jnp.where(usable.any(), usable.argmax() + 1, len(candidates)).astype(tried.dtype)
        return assigned.at[worst].set(choice), tried.at[worst].set(used)

    return jax.lax.while_loop(going, replace_worst, (start, jnp.zeros_like(start)))[0]
