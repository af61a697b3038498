"""How the distances between observed points behave over a window of time (pre-segmentation, section 4.1)."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

MIN_PAIR_FRAMES = 3  # frames in which both must be seen before a pair can be ruled out


class PairStatistics(NamedTuple):
    """Distances between points over a window, in millimetres; all 0 where the pair was never seen together."""

    smallest: Float[Array, "points points"]
    largest: Float[Array, "points points"]
    mean: Float[Array, "points points"]
    num_frames: Int[Array, "points points"]


def pair_statistics(
    window: Float[Array, "window_frames points 3"], present: Bool[Array, "window_frames points"]
) -> PairStatistics:
    """Smallest, largest and mean distance of each pair over the frames of the window in which both are seen.

    Arguments:
        window: positions in millimetres; what stands where a point is not `present` does not matter.
        present: False for padding, missing points and frames beyond the recording.
    """
    window = jnp.where(present[..., None], window, 0)
    points = window.shape[1]
    zero, far = jnp.zeros((points, points), window.dtype), jnp.full((points, points), jnp.inf, window.dtype)

    # A frame at a time: the distances of all frames at once would not stay in the cache.
    def add(sums, frame):
        smallest, largest, total, count = sums
        position, seen = frame
        both = seen[:, None] & seen[None]
        distance = _distances(position)
        return (
            jnp.minimum(smallest, jnp.where(both, distance, jnp.inf)),
            jnp.maximum(largest, jnp.where(both, distance, 0)),
            total + jnp.where(both, distance, 0),
            count + both.astype(jnp.int32),
        ), None

    start = far, zero, zero, jnp.zeros((points, points), jnp.int32)
    (smallest, largest, total, count), _ = jax.lax.scan(add, start, (window, present))
    mean = total / jnp.maximum(count, 1).astype(total.dtype)
    return PairStatistics(jnp.where(count > 0, smallest, 0), largest, mean, count)


def segmentation_matrix(
    window: Float[Array, "window_frames points 3"],
    present: Bool[Array, "window_frames points"],
    max_extent: Float[Array, ""] | float,
    max_ratio: Float[Array, ""] | float,
) -> Bool[Array, "points points"]:
    """Which pairs of points may belong to one segment (Eqs. 1 and 2).

    Arguments:
        window: positions in millimetres in the frames K + n delta, n = 0 to 10, of the paper; see `pair_statistics`.
        present: where they are seen.
        max_extent: the largest distance within any segment, in millimetres.
        max_ratio: the largest distortion ratio of any segment.

    Our reading: both are of all segments, also of those identified before, so that a frame has one matrix. The frames
    are those in which both points are seen, and with fewer than `MIN_PAIR_FRAMES` of them the pair stays possible; so
    Eq. 1 rules it out only when Eq. 2 can be judged as well. Points that are in no frame of the window pair with none,
    and no point pairs with itself.
    """
    pairs = pair_statistics(window, present)
    near = pairs.largest < (1 + max_ratio) * max_extent
    steady = pairs.largest - pairs.smallest < max_ratio * pairs.mean
    few = pairs.num_frames < MIN_PAIR_FRAMES
    seen = present.any(0)
    others = seen[:, None] & seen[None] & ~jnp.eye(len(seen), dtype=bool)
    return others & (few | (near & steady))


@jax.jit
def segmentation_matrices(
    windows: Float[Array, "windows window_frames points 3"],
    present: Bool[Array, "windows window_frames points"],
    max_extent: Float[Array, "windows"],
    max_ratio: Float[Array, "windows"],
) -> Bool[Array, "windows points points"]:
    """`segmentation_matrix` for many windows, one after the other so that each stays in the cache."""

    def one(arguments):
        return segmentation_matrix(*arguments)

    return jax.lax.map(one, (windows, present, max_extent, max_ratio))


def _distances(position: Float[Array, "points 3"]) -> Float[Array, "points points"]:
    """From differences; the Gram form would lose 0.07 mm at 5 m from the origin."""
    x, y, z = (position[:, None, k] - position[None, :, k] for k in range(3))
    return jnp.sqrt(x * x + y * y + z * z)
