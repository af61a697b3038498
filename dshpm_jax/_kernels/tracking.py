"""Points linked from frame to frame (pre-tracking, section 4.1).

The paper takes pre-tracked trajectories as given. Our reading: every point is predicted from its own motion and from
how its neighbours deviate from theirs, and linked to the nearest point of the next frame only where neither end has a
second choice nearly as good. The recording is tracked forwards and backwards, and links on which the two disagree are
cut: a trajectory that mixes two markers costs the labelling more than one that is broken.
"""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from dshpm_jax._types import NO_MATCH

NOISE = 12.0  # mm that a steady point may miss its prediction by: noise, soft tissue, and a margin
ACCELERATION = (
    150e3  # mm/s^2 that a prediction may miss by; impacts exceed it, and then the neighbours' deviation helps
)
SPEED = 20e3  # mm/s, a foot in a sprint: how far a point may go in the first frame, when nothing is known
RELATIVE_SPEED = 12e3  # mm/s between a new point and the neighbours whose velocity it is given
REACH = 150.0  # mm, the standard deviation of the weight that neighbours have
MISS_FACTOR = 3.0  # a point may miss its prediction by this multiple of its or its neighbours' recent misses
MISS_DECAY = 0.8  # what is left of a recent miss after a frame
NEW_MISS = 3.0  # mm, the recent miss of a point that has none yet
CURVATURE = 0.5  # share of the last change of velocity that is expected once more: 0 and 1 link worse
RIVAL_RATIO = 2.5  # a second choice this many times farther away is no rival
RIVAL_MARGIN = 1.5  # mm that it must be farther besides
LOOSE_RATIO = 1.3  # the same for the provisional links from which deviations are taken
NUM_ROUNDS = 3  # rounds of mutual nearest pairs; pairs left after three are rivals of one another

CHUNK_FRAMES = 512
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
    present = np.isfinite(points).all(-1)
    frames, width = present.shape
    order = np.argsort(~present, axis=1, kind="stable")[:, : int(present.sum(1).max(initial=0))]
    packed = np.take_along_axis(points, order[..., None], axis=1).astype(np.float32)
    links = _both_ways(packed, rate)
    t, i = np.nonzero(links != NO_MATCH)
    found = np.full((frames, width), NO_MATCH, dtype=np.int32)
    found[t, order[t, i]] = order[t + 1, links[t, i]]
    return found


def _both_ways(points: Float[np.ndarray, "frames points 3"], rate: float) -> Int[np.ndarray, "frames points"]:
    """The links of the forward and of the backward pass, as far as they do not contradict each other.

    A link stands if both passes make it; or if one does, along a track whose velocity it knew, while the other had only
    just come upon the point and linked nothing.
    """
    frames, width = points.shape[:2]
    if frames < 2 or not width:
        return np.full((frames, width), NO_MATCH)
    (ahead, tracked), (back, tracked_back) = _passes(np.stack([points, points[::-1]]), rate)
    ahead, tracked = ahead[:-1], tracked[:-1]
    t, j = np.nonzero(back[:-1] != NO_MATCH)
    backward = np.full_like(ahead, NO_MATCH)  # the backward pass's links, written as forward ones
    backward[frames - 2 - t, back[t, j]] = j
    tracked_back = tracked_back[-2::-1]  # of frame t + 1 in row t

    def known(links):
        return np.take_along_axis(tracked_back, np.maximum(links, 0), axis=1) & (links != NO_MATCH)

    links = np.where(ahead == backward, ahead, NO_MATCH)
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


def _passes(points: Float[np.ndarray, "passes frames points 3"], rate: float):
    """For each pass its links, and which points were tracked when they were linked, both (frames, points).

    Frames go through in chunks of one size and points in few widths, so that few programs are compiled.
    """
    passes, frames, width = points.shape[:3]
    padded_width = _bucket(width)
    padded = np.full((passes, -(-frames // CHUNK_FRAMES) * CHUNK_FRAMES, padded_width, 3), np.nan, np.float32)
    padded[:, :frames, :width] = points
    state = _nothing_yet(passes, padded_width)
    parts = []
    for start in range(0, frames, CHUNK_FRAMES):
        state, part = track_chunk(state, padded[:, start : start + CHUNK_FRAMES], np.float32(1 / rate))
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
    state: TrackState, points: Float[Array, "passes frames points 3"], seconds: Float[Array, ""]
) -> tuple[TrackState, tuple[Int[Array, "passes frames points"], Bool[Array, "passes frames points"]]]:
    """Carries `state` through the frames of a chunk, each pass by itself.

    Arguments:
        state: before the first frame, with a leading axis for the passes.
        points: millimetres, NaN where empty.
        seconds: between frames.

    Returns the state after the last frame and, for each frame, the links that lead into it: for each row of the frame
    before, the row in this one or `NO_MATCH`; and which rows of the frame before were tracked already.
    """

    def one_pass(state, points):
        def step(state, frame):
            after, links = _advance(state, frame, seconds)
            return after, (links, state.tracked)

        return jax.lax.scan(step, state, points)

    return jax.vmap(one_pass)(state, points)


def _advance(before: TrackState, frame: Float[Array, "points 3"], seconds) -> tuple[TrackState, Int[Array, "points"]]:
    """Links the points of `before` to those of `frame`."""
    seen = jnp.isfinite(frame).all(-1)
    frame = jnp.where(seen[:, None], frame, 0)
    closeness = _closeness(before)
    velocity, gate = _expectation(before, closeness, seconds)
    allowed = before.seen[:, None] & seen[None]
    distance = _distances(before.position + velocity, frame, allowed, gate)
    # Neighbours brake and turn together: a first, tentative linking says by how much each misses its prediction, and
    # every point is predicted anew with the misses of its neighbours, its own left out.
    tentative = _mutual_nearest(distance, LOOSE_RATIO, 0.0)
    linked = tentative != NO_MATCH
    miss = jnp.where(linked[:, None], frame[tentative] - before.position - velocity, 0)
    weight = closeness * jnp.where(linked, jnp.where(before.tracked, 1.0, 0.3), 0.0)[None]
    predicted = before.position + velocity + (weight @ miss) / (weight.sum(1) + 0.3)[:, None]
    links = _unrivalled(_distances(predicted, frame, allowed, gate))
    return _state_after(before, frame, seen, links, velocity), links


def _closeness(state: TrackState) -> Float[Array, "points points"]:
    """How much each point (row) heeds each other (column): 1 side by side, 0 far away, to itself or to nothing."""
    count = state.seen.shape[0]
    square = ((state.position[:, None] - state.position[None]) ** 2).sum(-1)
    others = state.seen[:, None] & state.seen[None] & ~jnp.eye(count, dtype=bool)
    return jnp.where(others, jnp.exp(square * (-0.5 / REACH**2)), 0)


def _expectation(state: TrackState, closeness, seconds) -> tuple[Float[Array, "points 3"], Float[Array, "points"]]:
    """The displacement expected of each point, and the distance (mm) by which it may miss.

    A point without a past moves as its neighbours do on the average.
    """
    weight = closeness * state.tracked.astype(closeness.dtype)[None]
    total = weight.sum(1) + 1e-6  # keeps the quotient finite where there is no neighbour
    around, miss_around = (weight @ state.velocity) / total[:, None], (weight @ state.miss) / total
    velocity = jnp.where(state.tracked[:, None], state.velocity + CURVATURE * state.change, around)
    jerk = ACCELERATION * seconds**2
    steady = NOISE + jnp.minimum(jerk, MISS_FACTOR * jnp.maximum(state.miss, miss_around) + jerk / 4)
    fresh = jnp.where(total > 1e-3, RELATIVE_SPEED, SPEED) * seconds
    return velocity, jnp.where(state.tracked, steady, fresh)


def _distances(predicted, frame, allowed, gate) -> Float[Array, "points points"]:
    """From each prediction (row) to each point (column), infinite beyond the gate."""
    square = ((predicted[:, None] - frame[None]) ** 2).sum(-1)
    return jnp.where(allowed & (square <= (gate**2)[:, None]), jnp.sqrt(square), jnp.inf)


def _unrivalled(distance: Float[Array, "points points"]) -> Int[Array, "points"]:
    """One-to-one links by rounds of mutual nearest pairs; those accepted are no rivals in the next round."""
    count = distance.shape[0]
    links = jnp.full(count, NO_MATCH)
    for _ in range(NUM_ROUNDS):
        new = _mutual_nearest(distance, RIVAL_RATIO, RIVAL_MARGIN)
        links = jnp.where(new != NO_MATCH, new, links)
        taken = _inverse(new) != NO_MATCH
        distance = jnp.where((new != NO_MATCH)[:, None] | taken[None], jnp.inf, distance)
    return links


def _mutual_nearest(distance: Float[Array, "points points"], ratio: float, margin: float) -> Int[Array, "points"]:
    """Pairs that are each other's nearest, and no other choice of either within `ratio` times that plus `margin`."""
    rows = jnp.arange(distance.shape[0])
    column, row = distance.argmin(1), distance.argmin(0)
    nearest = distance[rows, column]
    chosen = (rows[:, None] == row[None]) | (rows[None] == column[:, None])
    second = jnp.where(chosen, jnp.inf, distance)
    rival = jnp.minimum(second.min(1), second.min(0)[column])
    mutual = (row[column] == rows) & jnp.isfinite(nearest) & (rival >= ratio * nearest + margin)
    return jnp.where(mutual, column, NO_MATCH)


def _inverse(links: Int[Array, "points"]) -> Int[Array, "points"]:
    """For each point of the next frame the point that leads to it, or `NO_MATCH`."""
    count = links.shape[0]
    target = jnp.where(links == NO_MATCH, count, links)
    return jnp.full(count, NO_MATCH).at[target].set(jnp.arange(count), mode="drop")


def _state_after(before: TrackState, frame, seen, links, expected) -> TrackState:
    source = _inverse(links)
    tracked = source != NO_MATCH
    velocity = jnp.where(tracked[:, None], frame - before.position[source], 0)
    known = tracked & before.tracked[source]
    missed = jnp.sqrt(((velocity - expected[source]) ** 2).sum(-1))
    miss = jnp.where(known, jnp.maximum(MISS_DECAY * before.miss[source], missed), NEW_MISS)
    change = jnp.where(known[:, None], velocity - before.velocity[source], 0)
    return TrackState(frame, velocity, change, seen, tracked, miss)
