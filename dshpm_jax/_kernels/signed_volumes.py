"""Whether points that have labels are a body or its mirror image: volumes that four of them span."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from dshpm_jax._types import NO_MATCH

MOST_MARKERS = 256
"""count; markers of a model at most."""


@jax.jit
def volume_llr(
    points: Float[Array, "frames points 3"],
    labels: Int[Array, "labellings points"],
    fours: Int[Array, "fours 4"],
    mean: Float[Array, " fours"],
    sd: Float[Array, " fours"],
    dof: Float[Array, ""],
    background: Float[Array, ""],
    limit: Float[Array, ""],
) -> Float[Array, "labellings fours"]:
    """Log-likelihood ratios of the mean volumes (nats), 0 where a four is not labelled or never seen together.

    Arguments:
        points: places (mm), NaN where one is not seen.
        mean, sd: of each four's volume over its edges; padded fours have sd infinite.
        dof, background: see `SetTuning`. limit: no four says more, for or against (nats).
    """

    def one(labels):
        return _of_labelling(points, labels, fours, mean, sd, dof, background, limit)

    return jax.vmap(one)(labels)


def _of_labelling(points, labels, fours, mean, sd, dof, background, limit):
    place = jnp.where(labels != NO_MATCH, labels, MOST_MARKERS)  # the last place is of points without a label
    in_order = jnp.arange(len(labels), dtype=labels.dtype)
    holder = jnp.full(MOST_MARKERS + 1, NO_MATCH, labels.dtype).at[place].set(in_order)
    holds = holder[fours]
    known = (holds != NO_MATCH).all(-1)
    corner = points[:, jnp.maximum(holds, 0)]
    first = corner[:, :, 0]
    a, b, c = (corner[:, :, k] - first for k in (1, 2, 3))
    edges = jnp.linalg.norm(a, axis=-1) * jnp.linalg.norm(b, axis=-1) * jnp.linalg.norm(c, axis=-1)
    volume = (a * jnp.cross(b, c)).sum(-1) / jnp.maximum(edges, 1e-9)
    seen = jnp.isfinite(volume)
    count = seen.sum(0).astype(volume.dtype)
    volume = jnp.where(seen, volume, 0.0).sum(0) / jnp.maximum(count, 1.0)
    z, far = (volume - mean) / sd, volume / background
    llr = -0.5 * (dof + 1) * jnp.log1p(z * z / dof) - jnp.log(sd) + 0.5 * far * far + jnp.log(background)
    return jnp.where(known & (count > 0) & jnp.isfinite(sd), jnp.clip(llr, -limit, limit), 0.0)
