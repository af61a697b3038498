"""CT-based iterative identification of one segment in one frame (section 4.2)."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Int

from dshpm_jax._control.fitting import fit_one
from dshpm_jax._control.scene import Known, Scene
from dshpm_jax._control.targets import with_virtual_join
from dshpm_jax._requests import Control, MatchSegment, SegmentMatches, Target
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True, eq=False)
class SegmentMatch:
    """A segment's markers in one frame.

    Attributes:
        segment, frame: what was matched where.
        holder: the trajectory of each of the segment's markers, `NO_MATCH` where lost.
        error: the match score, under 1 (Eq. 4).
    """

    segment: int
    frame: int
    holder: Int[np.ndarray, " markers"]
    error: float

    @property
    def size(self) -> int:
        return int((self.holder != NO_MATCH).sum())


def match_segment(
    scene: Scene,
    known: Known,
    segment: int,
    frame: int,
    use_joins: bool = True,
    banned: frozenset[tuple[int, int]] = frozenset(),
) -> Control:
    """The best match of `segment` in `frame`, or None.

    Arguments:
        use_joins: whether markers that are identified already are the pivots (section 4.2.1); else every pivot
            hypothesis is tried, and what was known of the segment's markers is not used.
        banned: pairs of marker and trajectory that must not be matched (section 4.3.3).

    Our reading: "first acceptable" is the paper's rule; the full method scores all hypotheses and takes the best.
    """
    here, points = scene.at(frame)
    if len(here) < 2:
        return None
    target = scene.targets[segment]
    rigid = yield from scene.rigid(frame)
    identity = known.identity[here]
    own = scene.body.owned[segment, identity]
    free = (identity == NO_MATCH) | (own & (not use_joins))
    pinned = np.full(len(target.markers), NO_MATCH)
    if use_joins:
        holder = known.holders(scene, target.markers, frame)
        pinned = np.where(holder != NO_MATCH, np.searchsorted(here, holder), NO_MATCH)
        if (pinned == NO_MATCH).all():
            target, points, free, rigid, pinned = yield from _pin_virtual_join(
                scene, known, segment, frame, points, free, rigid, pinned
            )
    pivot, assumed = _hypotheses(pinned, free)
    if not len(pivot):
        return None
    matches = yield MatchSegment(target, points, free, rigid, pinned, pivot, assumed)
    chosen = _choose(scene, matches, target, here, banned)
    tried = len(matches.fits) if chosen is None or scene.settings.method == "full" else chosen + 1
    known.fits += int(matches.fits[:tried].sum())
    if chosen is None:
        return None
    assigned = matches.assigned[chosen][: len(scene.targets[segment].markers)]
    holder = np.where(assigned != NO_MATCH, here[np.minimum(assigned, len(here) - 1)], NO_MATCH)
    return SegmentMatch(segment, frame, holder, float(matches.error[chosen]))


def _hypotheses(
    pinned: Int[np.ndarray, " columns"], free: Bool[np.ndarray, " points"]
) -> tuple[np.ndarray, np.ndarray]:
    """Pivots and the points assumed for them: a known join is the unique pivot, else every marker is at every point."""
    known = np.flatnonzero(pinned != NO_MATCH)
    if len(known):
        return known, pinned[known]
    pivot, assumed = np.meshgrid(np.arange(len(pinned)), np.flatnonzero(free), indexing="ij")
    return pivot.ravel(), assumed.ravel()


def _pin_virtual_join(scene: Scene, known: Known, segment: int, frame: int, points, free, rigid, pinned) -> Control:
    """The segment with its virtual join as a pinned column, if an identified parent predicts one (section 4.4)."""
    target = scene.targets[segment]
    join, parent = scene.model.segments[segment].virtual_join, scene.model.segments[segment].parent
    unchanged = target, points, free, rigid, pinned
    if join is None:
        return unchanged
    above = scene.targets[parent]
    place, there = known.places(scene, above, frame)
    if there.sum() < 3:
        return unchanged
    known.fits += 1
    centre = yield from _predict(above, place, there, join.in_parent)
    if centre is None:
        return unchanged
    size = len(points)
    wider = np.ones((size + 1, size + 1), bool)
    wider[:size, :size] = rigid
    return (
        with_virtual_join(target, join.in_segment, join.spread, scene.settings.measurement_noise),
        np.concatenate([points, centre[None]]),
        np.append(free, False),
        wider,
        np.append(pinned, size),
    )


def _predict(target: Target, points: np.ndarray, there: np.ndarray, place: np.ndarray) -> Control:
    """Where `place` of the target's shape is, or None without a pose."""
    shape = np.concatenate([target.shape, place[None]])
    grown = replace(target, shape=shape, scale=np.append(target.scale, 1.0))
    predicted, _, posed = yield from fit_one(grown, np.vstack([points, np.full(3, np.nan)]), np.append(there, False))
    return predicted[-1] if posed else None


def _choose(
    scene: Scene, matches: SegmentMatches, target: Target, here: np.ndarray, banned: frozenset[tuple[int, int]]
) -> int | None:
    """The first or the best accepted hypothesis, ties by rank; None if none is accepted."""
    accepted = matches.accepted.copy()
    for marker, trajectory in banned:
        point, column = np.flatnonzero(here == trajectory), np.flatnonzero(target.markers == marker)
        if len(point) and len(column):
            accepted &= matches.assigned[:, column[0]] != point[0]
    rows = np.flatnonzero(accepted)
    if not len(rows):
        return None
    if scene.settings.method != "full":
        return int(rows[0])
    # A lost marker costs as much as one at the limit of what Eq. 4 allows.
    size = (target.markers != NO_MATCH).sum()
    cost = (matches.matched * matches.error + (size - matches.matched)) / size
    return int(rows[np.argmin(np.round(cost[rows], 4))])
