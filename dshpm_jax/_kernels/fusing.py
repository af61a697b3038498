"""How kernels keep XLA on a CPU from computing things again and again: the rigid fit takes a third of the time.

XLA computes a value anew in each fusion that uses it, once for every element that is broadcast from it, and drops
optimization barriers before it fuses. A loop that indexes its operands is not vectorized where the fusion is large, and
sums over a short axis are many times slower than the same sums written out.
"""

import functools
from collections.abc import Callable
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

T = TypeVar("T")


def stored(always: Bool[Array, ""], function: Callable[..., T], *arguments: Any) -> T:
    """`function(*arguments)`, computed once and kept in memory: what a conditional takes and returns is.

    Arguments:
        always: true, and computed from the kernel's input so that XLA does not know it.
    """
    if jax.default_backend() != "cpu":
        return function(*arguments)  # others would wait for the host at each condition
    like = jax.eval_shape(function, *arguments)
    nothing = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), like)
    return jax.lax.cond(always, function, lambda *_: nothing, *arguments)


def opaque_true(weights: Float[Array, "..."]) -> Bool[Array, ""]:
    """True, which XLA cannot know, from numbers none of which is negative; NaN are not."""
    return jnp.logical_not(weights.ravel()[:1].sum() < 0)


def total(terms: Float[Array, "terms *rest"]) -> Float[Array, "*rest"]:
    """Sum over the major axis, which is to be short."""
    return functools.reduce(jnp.add, terms)


def square_length(vectors: Float[Array, "*axes 3 lanes"]) -> Float[Array, "*axes lanes"]:
    """Sum of the squares over the last axis but one."""
    return total(jnp.moveaxis(vectors * vectors, -2, 0))


def all_finite(vectors: Float[Array, "*axes 3 lanes"]) -> Bool[Array, "*axes lanes"]:
    """Whether all of the last axis but one are numbers."""
    return functools.reduce(jnp.logical_and, jnp.moveaxis(jnp.isfinite(vectors), -2, 0))
