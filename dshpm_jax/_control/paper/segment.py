"""CT-based iterative identification of one segment in one frame (section 4.2)."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Int

from dshpm_jax._control.paper.pose import fit_one
from dshpm_jax._control.partial_labels import PartialLabels
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.targets import with_virtual_join
from dshpm_jax._requests import Control, MatchSegment, SegmentMatches, Target
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH


@dataclass(frozen=True, eq=False)
class SegmentMatch:
    """A segment's markers in one frame.

    Attributes:
        segment, frame: what was matched where.
        trajectories: that of each of the segment's markers, `NO_MATCH` where lost.
        error: the match score, under 1 (Eq. 4).
    """

    segment: int
    frame: int
    trajectories: Int[np.ndarray, " markers"]
    error: float

    @property
    def size(self) -> int:
        return int((self.trajectories != NO_MATCH).sum())


def match_segment(
    problem: LabellingProblem,
    known: PartialLabels,
    segment: int,
    frame: int,
    use_joins: bool = True,
    banned: frozenset[tuple[int, int]] = frozenset(),
) -> Control[SegmentMatch | None]:
    """The best match of `segment` in `frame`, or None.

    Arguments:
        use_joins: whether markers that are identified already are the pivots (section 4.2.1); else every pivot
            hypothesis is tried, and what was known of the segment's markers is not used.
        banned: pairs of marker and trajectory that must not be matched (section 4.3.3).

    Our reading: "first acceptable" is the paper's rule; the full method scores all hypotheses and takes the best.
    """
    here, _ = problem.at(frame)
    if len(here) < 2:
        return None
    asked = yield from _asked(problem, known, segment, frame, use_joins, banned)
    if not len(asked.pivot):
        return None
    matches: SegmentMatches = yield asked
    chosen = _choose(asked, matches)
    if chosen is None:
        return None
    assigned = matches.assigned[chosen][: len(problem.targets[segment].markers)]
    found = np.where(assigned != NO_MATCH, here[np.minimum(assigned, len(here) - 1)], NO_MATCH)
    return SegmentMatch(segment, frame, found, float(matches.error[chosen]))


def _asked(
    problem: LabellingProblem,
    known: PartialLabels,
    segment: int,
    frame: int,
    use_joins: bool,
    banned: frozenset[tuple[int, int]],
) -> Control[MatchSegment]:
    """What the matcher is asked for `segment` in `frame`."""
    here, points = problem.at(frame)
    target = problem.targets[segment]
    rigid = yield from problem.rigid(frame)
    identity = known.identity[here]
    own = problem.prepared.owned[segment, identity]
    free = ((identity == NO_MATCH) | (own & (not use_joins))) & ~known.given[here]
    carrying = known.trajectories_of(problem, target.markers, frame)
    if not use_joins:
        carrying = np.where(known.given[carrying], carrying, NO_MATCH)
    pinned = np.where(carrying != NO_MATCH, np.searchsorted(here, carrying), NO_MATCH)
    if use_joins and (pinned == NO_MATCH).all():
        target, points, free, rigid, pinned = yield from _pin_virtual_join(
            problem, known, segment, frame, points, free, rigid, pinned
        )
    pairs = tuple(_banned_pairs(target, here, banned))
    first = problem.settings.method != "full"
    return MatchSegment(target, points, free, rigid, pinned, *_hypotheses(pinned, free), pairs, first)


def _banned_pairs(target: Target, here: np.ndarray, banned: frozenset[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Pairs of marker and trajectory as columns of the target and points of the frame."""
    for marker, trajectory in sorted(banned):
        point, column = np.flatnonzero(here == trajectory), np.flatnonzero(target.markers == marker)
        if len(point) and len(column):
            yield int(column[0]), int(point[0])


def _hypotheses(
    pinned: Int[np.ndarray, " columns"], free: Bool[np.ndarray, " points"]
) -> tuple[np.ndarray, np.ndarray]:
    """Pivots and the points assumed for them: a known join is the unique pivot, else every marker is at every point."""
    known = np.flatnonzero(pinned != NO_MATCH)
    if len(known):
        return known, pinned[known]
    pivot, assumed = np.meshgrid(np.arange(len(pinned)), np.flatnonzero(free), indexing="ij")
    return pivot.ravel(), assumed.ravel()


def _pin_virtual_join(
    problem: LabellingProblem, known: PartialLabels, segment: int, frame: int, points, free, rigid, pinned
) -> Control[tuple]:
    """The segment with its virtual join as a pinned column, if an identified parent predicts one (section 4.4)."""
    target = problem.targets[segment]
    join, parent = problem.model.segments[segment].virtual_join, problem.model.segments[segment].parent
    unchanged = target, points, free, rigid, pinned
    if join is None:
        return unchanged
    above = problem.targets[parent]
    place, there = known.places(problem, above, frame)
    if there.sum() < MIN_FIT_POINTS:
        return unchanged
    centre = yield from _predict(above, place, there, join.in_parent)
    if centre is None:
        return unchanged
    slack = problem.tuning.join_slack_sds * join.spread + problem.settings.measurement_noise
    size = len(points)
    wider = np.ones((size + 1, size + 1), bool)
    wider[:size, :size] = rigid
    return (
        with_virtual_join(target, join.in_segment, slack),
        np.concatenate([points, centre[None]]),
        np.append(free, False),
        wider,
        np.append(pinned, size),
    )


def _predict(target: Target, points: np.ndarray, there: np.ndarray, place: np.ndarray) -> Control[np.ndarray | None]:
    """Where `place` of the target's shape is, or None without a pose."""
    shape = np.concatenate([target.shape, place[None]])
    grown = replace(target, shape=shape, scale=np.append(target.scale, 1.0))
    predicted, _, posed = yield from fit_one(grown, np.vstack([points, np.full(3, np.nan)]), np.append(there, False))
    return predicted[-1] if posed else None


def _choose(asked: MatchSegment, matches: SegmentMatches) -> int | None:
    """The first or the best acceptable hypothesis, ties by rank; None if none is."""
    rows = asked.acceptable(matches)
    if not len(rows):
        return None
    if asked.first_acceptable:
        return int(rows[0])
    # A lost marker costs as much as one at the limit of what Eq. 4 allows.
    size = (asked.target.markers != NO_MATCH).sum()
    cost = (matches.matched * matches.error + (size - matches.matched)) / size
    return int(rows[np.argmin(np.round(cost[rows], 4))])
