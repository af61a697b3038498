"""Points linked from frame to frame (pre-tracking, section 4.1).

The paper takes pre-tracked trajectories as given. Our reading: every point is predicted from its own motion and from
how its neighbours deviate from theirs, and linked to the nearest point of the next frame only where neither end has a
second choice nearly as good. The recording is tracked forwards and backwards, and links on which the two disagree are
cut: a trajectory that mixes two markers costs the labelling more than one that is broken.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from dshpm_jax._columns import ACCELERATION, SPEED
from dshpm_jax._geometry import is_seen
from dshpm_jax._types import NO_MATCH

NOISE = 12.0
"""mm; used in `_expectation`: a steady point may always miss its prediction by this; by hand: noise, soft tissue, and a
margin."""

STEADY_SHARE = 0.25
"""share of what `ACCELERATION` explains; used in `_expectation`: what a point that kept to its predictions may miss by,
beside `NOISE`; by hand."""

RELATIVE_SPEED = 12e3
"""mm/s; used in `_expectation`: if only the velocity of its neighbours is known, a point may go no farther from it; by
hand."""

REACH = 400.0
"""mm; used in `_closeness`: if a neighbour is farther than this, it has no weight (half of it at 180); by hand."""

MISS_FACTOR = 3.0
"""factor; used in `_expectation`: a point may miss its prediction by this multiple of its or its neighbours' recent
misses; by hand."""

MISS_DECAY = 0.8
"""share; used in `_state_after`: what is left of a recent miss after a frame; by hand."""

NEW_MISS = 3.0
"""mm; used in `_state_after`: the recent miss of a point that has none yet; by hand."""

CURVATURE = 0.5
"""share; used in `_expectation`: of the last change of velocity, what is expected once more; by hand: 0 and 1 link
worse."""

NEW_TRUST = 0.3
"""weight; used in `_advance`: of the deviation of a point whose velocity is not measured, beside 1; by hand."""

DEVIATION_PRIOR = 0.3
"""weight; used in `_advance`: of no deviation at all beside those of the neighbours; by hand."""

RIVAL_RATIO = 2.5
"""factor; used in `_unrivalled`: if a second choice is this many times farther away, it is no rival; by hand."""

RIVAL_MARGIN = 1.5
"""mm; used in `_unrivalled`: what a second choice must be farther away besides; by hand."""

LOOSE_RATIO = 1.3
"""factor; used in `_advance`: `RIVAL_RATIO` of the provisional links from which deviations are taken; by hand."""

NUM_ROUNDS = 3
"""count; used in `_unrivalled`: rounds of mutual nearest pairs; by hand: pairs left after three are rivals of one
another."""

AWAY = 1e12  # mm^2, where there is no point
INFINITE = 0x7F800000  # the bits of a float32 infinity
CHUNK_FRAMES = 128
POINT_BUCKETS = (32, 64, 128, 256)  # beyond, multiples of the last


class TrackState(NamedTuple):
    """What the next frame needs of the frame before, a row a point.

    Attributes:
        position, velocity, change: mm, mm a frame, and the last change of velocity.
        seen: whether there is a point in the row.
        tracked: whether it continues a point, so that its velocity is measured.
        miss: mm, the recent distance between prediction and point.
    """

    position: Float[Array, "points 3"]
    velocity: Float[Array, "points 3"]
    change: Float[Array, "points 3"]
    seen: Bool[Array, "points"]
    tracked: Bool[Array, "points"]
    miss: Float[Array, "points"]


def track(points: Float[np.ndarray, "frames points 3"], rate: float) -> Int[np.ndarray, "frames points"]:
    """For each point the column of the next frame that continues it, or `NO_MATCH`.

    Arguments:
        points: millimetres, NaN where empty; columns need not mean anything.
        rate: frames a second.

    No two points share a continuation, and a gap ends a track. The order of the columns does not matter.
    """
    frames, width = points.shape[:2]
    present = is_seen(points)
    order = np.argsort(~present, axis=1, kind="stable")[:, : int(present.sum(1).max(initial=0))]
    packed = np.take_along_axis(points, order[..., None], axis=1)
    links = _both_ways(packed, rate)
    t, i = np.nonzero(links != NO_MATCH)
    found = np.full((frames, width), NO_MATCH, dtype=np.int32)
    found[t, order[t, i]] = order[t + 1, links[t, i]]
    return found


def _both_ways(points: Float[np.ndarray, "frames points 3"], rate: float) -> Int[np.ndarray, "frames points"]:
    """The links of the forward and of the backward pass, as far as they do not contradict each other.

    A link stands if both passes make it, and one of them along a track whose velocity it knew; or if one does, along
    such a track, while the other had only just come upon the point and linked nothing. So a lone pair of points is no
    track, except in a recording of two frames: markers that blink in turn look like one in motion.
    """
    frames, width = points.shape[:2]
    if frames < 2 or not width:
        return np.full((frames, width), NO_MATCH)
    middle = _middles(points)
    points = points - middle[:, None]
    (ahead, tracked), (back, tracked_back) = _passes(
        np.stack([points, points[::-1]]), np.stack([middle, middle[::-1]]), rate
    )
    ahead, tracked = ahead[:-1], tracked[:-1]
    t, j = np.nonzero(back[:-1] != NO_MATCH)
    backward = np.full_like(ahead, NO_MATCH)  # the backward pass's links, written as forward ones
    backward[frames - 2 - t, back[t, j]] = j
    tracked_back = tracked_back[-2::-1]  # of frame t + 1 in row t

    def known(links):
        return np.take_along_axis(tracked_back, np.maximum(links, 0), axis=1) & (links != NO_MATCH)

    agreed = (ahead == backward) & (tracked | known(ahead) | (frames == 2))
    links = np.where(agreed, ahead, NO_MATCH)
    links = np.where((ahead == NO_MATCH) & ~tracked & known(backward), backward, links)
    links = np.where((backward == NO_MATCH) & tracked & ~known(ahead), ahead, links)
    links = _without_shared_ends(links)
    return np.concatenate([links, np.full((1, width), NO_MATCH)])


def _without_shared_ends(links: Int[np.ndarray, "frames points"]) -> Int[np.ndarray, "frames points"]:
    """Cuts links that lead to the same point."""
    t, i = np.nonzero(links != NO_MATCH)
    count = np.zeros(links.shape, dtype=int)
    np.add.at(count, (t, links[t, i]), 1)
    shared = np.take_along_axis(count, np.maximum(links, 0), axis=1) > 1
    return np.where(shared, NO_MATCH, links)


def _middles(points: Float[np.ndarray, "frames points 3"]) -> Float[np.ndarray, "frames 3"]:
    """The median of the points of each frame, which none that is astray moves; the origin where there is none."""
    ordered = np.sort(points, axis=1)  # NaN come last
    half = np.maximum(is_seen(points).sum(1) - 1, 0) // 2
    return np.nan_to_num(np.take_along_axis(ordered, half[:, None, None], axis=1)[:, 0])


def _passes(points: Float[np.ndarray, "passes frames points 3"], middle: Float[np.ndarray, "passes frames 3"], rate):
    """For each pass its links, and which points were tracked when they were linked, both (frames, points).

    Points are counted from the `middle` of their frame. Frames go through in chunks of one size and points in few
    widths, so that few programs are compiled.
    """
    passes, frames, width = points.shape[:3]
    padded_width, padded_frames = _bucket(width), -(-frames // CHUNK_FRAMES) * CHUNK_FRAMES
    padded = np.full((passes, padded_frames, padded_width, 3), np.nan, np.float32)
    padded[:, :frames, :width] = points
    shift = np.zeros((passes, padded_frames, 3), np.float32)
    shift[:, 1:frames] = np.diff(middle, axis=1)
    state = _nothing_yet(passes, padded_width)
    parts = []
    for start in range(0, frames, CHUNK_FRAMES):
        some = slice(start, start + CHUNK_FRAMES)
        state, part = track_chunk(state, padded[:, some], shift[:, some], np.float32(1 / rate))
        parts.append(jax.device_get(part))
    # The links found on reaching a frame are those of the frame before.
    links, tracked = (np.concatenate(x, axis=1)[:, 1:frames, :width] for x in zip(*parts))
    last = np.full((passes, 1, width), NO_MATCH)
    return zip(np.concatenate([links, last], axis=1), np.concatenate([tracked, last == 0], axis=1))


def _bucket(width: int) -> int:
    """The next of the widths that programs are compiled for."""
    largest = POINT_BUCKETS[-1]
    return next((b for b in POINT_BUCKETS if b >= width), -(-width // largest) * largest)


def _nothing_yet(passes: int, width: int) -> TrackState:
    vectors, flags = np.zeros((passes, width, 3), np.float32), np.zeros((passes, width), bool)
    return TrackState(vectors, vectors, vectors, flags, flags, np.zeros((passes, width), np.float32))  # pyright: ignore


@jax.jit
def track_chunk(
    state: TrackState,
    points: Float[Array, "passes frames points 3"],
    shift: Float[Array, "passes frames 3"],
    seconds: Float[Array, ""],
) -> tuple[TrackState, tuple[Int[Array, "passes frames points"], Bool[Array, "passes frames points"]]]:
    """Carries `state` through the frames of a chunk, each pass by itself.

    Arguments:
        state: before the first frame, with a leading axis for the passes.
        points: millimetres from a place amid them, NaN where empty.
        shift: how far that place has moved since the frame before.
        seconds: between frames.

    Returns the state after the last frame and, for each frame, the links that lead into it: for each row of the frame
    before, the row in this one or `NO_MATCH`; and which rows of the frame before were tracked already.
    """

    def one_pass(state, points, shift):
        def step(state, following):
            after, links = _advance(state, following[0], following[1], seconds)
            return after, (links, state.tracked)

        return jax.lax.scan(step, state, (points, shift))

    return jax.vmap(one_pass)(state, points, shift)


def _advance(
    before: TrackState, frame: Float[Array, "points 3"], shift: Float[Array, "3"], seconds: Float[Array, ""]
) -> tuple[TrackState, Int[Array, "points"]]:
    """Links the points of `before` to those of `frame`."""
    before = before._replace(position=before.position - shift[None])
    seen = jnp.isfinite(frame).all(-1)
    frame = jnp.where(seen[:, None], frame, 0)
    closeness = _closeness(before)
    velocity, gate = _expectation(before, closeness, seconds)
    reach = jnp.where(before.seen, gate, -1.0)
    # Neighbours brake and turn together: a first, tentative linking says by how much each misses its prediction, and
    # every point is predicted anew with the misses of its neighbours, its own left out.
    tentative = _mutual_nearest(before.position + velocity, frame, reach, seen, LOOSE_RATIO, 0.0)
    linked = tentative != NO_MATCH
    miss = jnp.where(linked[:, None], frame[tentative] - before.position - velocity, 0)
    trust = jnp.where(linked, jnp.where(before.tracked, 1.0, NEW_TRUST), 0.0)
    around, total = _weighted(closeness, trust, miss)
    links = _unrivalled(before.position + velocity + around / (total + DEVIATION_PRIOR)[:, None], frame, reach, seen)
    return _state_after(before, frame, seen, links, velocity), links


def _closeness(state: TrackState) -> Float[Array, "points points"]:
    """How much each point (row) heeds each other (column): 1 side by side, 0 far away, to itself or to nothing."""
    square = _squares(state.position, state.position, state.seen, state.seen)
    near = jnp.maximum(1 - square / REACH**2, 0) ** 3
    return jnp.where(jnp.eye(len(near), dtype=bool), 0, near)


def _weighted(closeness, trust, values) -> tuple[Float[Array, "points k"], Float[Array, "points"]]:
    """Sums of the neighbours' `values` with closeness times trust as weights, and the sum of the weights."""
    summed = closeness @ (trust[:, None] * jnp.concatenate([values, jnp.ones_like(values[:, :1])], axis=1))
    return summed[:, :-1], summed[:, -1]


def _expectation(state: TrackState, closeness, seconds) -> tuple[Float[Array, "points 3"], Float[Array, "points"]]:
    """The displacement expected of each point, and the distance (mm) by which it may miss.

    A point without a past moves as its neighbours do on the average.
    """
    known = jnp.concatenate([state.velocity, state.miss[:, None]], axis=1)
    around, total = _weighted(closeness, state.tracked.astype(known.dtype), known)
    around = around / jnp.maximum(total, 1e-6)[:, None]
    velocity = jnp.where(state.tracked[:, None], state.velocity + CURVATURE * state.change, around[:, :3])
    swerve = ACCELERATION * seconds**2
    steady = NOISE + jnp.minimum(swerve, MISS_FACTOR * jnp.maximum(state.miss, around[:, 3]) + STEADY_SHARE * swerve)
    fresh = jnp.where(total > 1e-3, RELATIVE_SPEED, SPEED) * seconds
    return velocity, jnp.where(state.tracked, steady, fresh)


def _unrivalled(predicted, frame, reach, seen) -> Int[Array, "points"]:
    """One-to-one links by rounds of mutual nearest pairs; those accepted are no rivals in the next round.

    Arguments:
        predicted, frame: (points, 3), mm.
        reach: the farthest that a prediction may miss (mm), negative where there is none.
        seen: which rows of `frame` hold a point.
    """

    def more(state):
        _, left, free, number = state
        return jnp.any(left >= 0) & jnp.any(free) & (number < NUM_ROUNDS)

    def link(state):
        links, left, free, number = state
        new = _mutual_nearest(predicted, frame, left, free, RIVAL_RATIO, RIVAL_MARGIN)
        found = new != NO_MATCH
        left = jnp.where(found | ~jnp.any(found), -1.0, left)  # another round would find nothing where this has not
        return jnp.where(found, new, links), left, free & (_inverse(new) == NO_MATCH), number + 1

    return jax.lax.while_loop(more, link, (jnp.full(len(frame), NO_MATCH, jnp.int32), reach, seen, 0))[0]


def _mutual_nearest(predicted, frame, reach, seen, ratio: float, margin: float) -> Int[Array, "points"]:
    """Pairs that are each other's nearest, and no other choice of either within `ratio` times that plus `margin`."""
    there, limit = reach >= 0, reach * jnp.abs(reach)
    back = _squares(predicted, frame, there, seen)  # both ways, as minima along the major axis are the faster ones
    ahead = _squares(frame, predicted, seen, there)
    choice, nearest, second = _two_nearest(jnp.where(ahead <= limit[None], ahead, jnp.inf))
    chosen_by, _, second_back = _two_nearest(jnp.where(back <= limit[:, None], back, jnp.inf))
    rival = jnp.sqrt(jnp.minimum(second, second_back[choice]))
    mutual = (chosen_by[choice] == jnp.arange(len(choice))) & jnp.isfinite(nearest)
    return jnp.where(mutual & (rival >= ratio * jnp.sqrt(nearest) + margin), choice, NO_MATCH)


def _squares(a, b, in_a, in_b) -> Float[Array, "n m"]:
    """Squared distances (mm^2) between two sets of points, `AWAY` and more where one is not in its set.

    A product of matrices: XLA would compute differences again for every use. It rounds by some 1e-7 of the squared
    distance from the origin, which is to be near: for points a metre off that is a tenth of a square millimetre.
    """
    from_a = (a * a).sum(1, keepdims=True) + jnp.where(in_a, 0.0, AWAY)[:, None]
    from_b = (b * b).sum(1, keepdims=True) + jnp.where(in_b, 0.0, AWAY)[:, None]
    left = jnp.concatenate([-2.0 * a, from_a, jnp.ones_like(from_a)], axis=1)
    right = jnp.concatenate([b, jnp.ones_like(from_b), from_b], axis=1)
    return jnp.maximum(left @ right.T, 0.0)


def _two_nearest(squares: Float[Array, "choices n"]):
    """For each column the row of its least element, that element, and the least but one.

    The row takes the place of the last bits of the number (of which eight are 0.003 %), so that one integer minimum
    finds both: an argmin takes six times as long. Of equals, the first row wins.
    """
    rows = jnp.arange(squares.shape[0], dtype=jnp.int32)[:, None]
    mask = jnp.int32((1 << (squares.shape[0] - 1).bit_length()) - 1)
    keys = (jax.lax.bitcast_convert_type(squares, jnp.int32) & ~mask) | rows
    first = keys.min(0)
    second = jnp.where(rows == (first & mask)[None], jnp.iinfo(jnp.int32).max, keys).min(0)
    return first & mask, _number(first & ~mask), _number(jnp.minimum(second, INFINITE) & ~mask)


def _number(bits: Int[Array, "n"]) -> Float[Array, "n"]:
    return jax.lax.bitcast_convert_type(bits, jnp.float32)


def _inverse(links: Int[Array, "points"]) -> Int[Array, "points"]:
    """For each point of the next frame the point that leads to it, or `NO_MATCH`."""
    count = links.shape[0]
    target = jnp.where(links == NO_MATCH, count, links)
    return jnp.full(count, NO_MATCH, jnp.int32).at[target].set(jnp.arange(count, dtype=jnp.int32), mode="drop")


def _state_after(before: TrackState, frame, seen, links, expected) -> TrackState:
    source = _inverse(links)
    tracked = source != NO_MATCH
    velocity = jnp.where(tracked[:, None], frame - before.position[source], 0)
    known = tracked & before.tracked[source]
    missed = jnp.sqrt(((velocity - expected[source]) ** 2).sum(-1))
    miss = jnp.where(known, jnp.maximum(MISS_DECAY * before.miss[source], missed), NEW_MISS)
    change = jnp.where(known[:, None], velocity - before.velocity[source], 0)
    return TrackState(frame, velocity, change, seen, tracked, miss)
