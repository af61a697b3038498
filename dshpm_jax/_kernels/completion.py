"""Lost markers of fitted hypotheses given the points near their predicted places (Fig. 3)."""

import jax.numpy as jnp
from jax import lax

from dshpm_jax._kernels.candidate_table import Problems, end_of

COMPLETIONS = 4  # rounds of completion


def complete(problems: Problems, request, predicted, assigned, wanted):
    """Nearest unclaimed point within reach of each lost marker, nearest pairs first; no point twice.

    As many rounds as there are columns would always do; a hypothesis that lacks more than a few is lost anyway. A
    round takes one point, so each column needs to know no more of its nearest points than there are rounds.
    """
    lists = _nearest(problems, request, predicted, assigned, wanted)

    def take(_, state):
        distance, point, assigned = state
        flat = distance.reshape(-1, len(request))  # by column, then by distance and index: the order of ties
        best = jnp.argmin(flat, axis=0)[None]
        found = jnp.take_along_axis(flat, best, axis=0) < jnp.inf
        at_point = jnp.take_along_axis(point.reshape(flat.shape), best, axis=0)
        here = (jnp.arange(len(assigned))[:, None] == best // COMPLETIONS) & found
        gone = here[:, None] | ((point == at_point[None]) & found[None])
        return jnp.where(gone, jnp.inf, distance), point, jnp.where(here, at_point, assigned)

    return lax.fori_loop(0, COMPLETIONS, take, (*lists, assigned))[2]


def _nearest(problems: Problems, request, predicted, assigned, wanted):
    """The `COMPLETIONS` nearest free points within reach of each wanted column: distances (infinite: none), points."""
    points = problems.points.transpose(2, 0, 1)[:, request]
    number = jnp.arange(points.shape[2], dtype=jnp.int32)[None]
    columns = end_of(jnp.any(problems.is_column, axis=0))

    def claim(column, unclaimed):
        return unclaimed & (number != assigned[column][:, None])

    unclaimed = lax.fori_loop(0, columns, claim, problems.free[request])
    reach = problems.reach[request].T

    def search(column, lists):
        apart = jnp.sqrt(sum((predicted[column, k][:, None] - points[k]) ** 2 for k in range(3)))
        near = unclaimed & (apart <= reach[column][:, None]) & wanted[column][:, None]
        distance, point = lax.top_k(jnp.where(near, -apart, -jnp.inf), COMPLETIONS)
        return tuple(x.at[column].set(y.T) for x, y in zip(lists, (-distance, point)))

    size = (len(wanted), COMPLETIONS, len(request))
    return lax.fori_loop(0, columns, search, (jnp.full(size, jnp.inf), jnp.zeros(size, jnp.int32)))
