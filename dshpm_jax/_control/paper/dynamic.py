"""The dynamic scheme over a key-frame range: match, verify, recruit, shift, correct, abandon (section 4.3, Fig. 1)."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from dshpm_jax._control.paper.pose import fit_one, mapping_error
from dshpm_jax._control.paper.segment import SegmentMatch, match_segment
from dshpm_jax._control.partial_labels import PartialLabels
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._hierarchy import children, depth_first
from dshpm_jax._requests import Control
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH, NO_PARENT


def key_frame(problem: LabellingProblem) -> int:
    """The first frame with enough of the model's markers, or the fullest (section 4.2)."""
    seen = (problem.trajectories.index != NO_MATCH).sum(1)
    full = np.flatnonzero(seen >= problem.settings.key_frame_coverage * problem.model.num_markers)
    return int(full[0]) if len(full) else int(np.argmax(seen))


def identify(problem: LabellingProblem, frame: int) -> Control[PartialLabels]:
    """Everything that can be identified in the key-frame range that begins at `frame` (Fig. 1).

    Segments are taken depth-first; those whose parent is not found wait until all other chains are done
    (section 4.4).
    """
    known = PartialLabels.nothing(problem)
    broken: list[int] = []
    segments = problem.model.segments
    for segment in depth_first(segments):
        parent = segments[segment].parent
        if parent != NO_PARENT and not known.found[parent]:
            broken.append(segment)
            continue
        yield from identify_segment(problem, known, segment, frame)
    for segment in broken:
        yield from identify_segment(problem, known, segment, frame)
    _drop_unconfirmed(problem, known)
    return known


def identify_segment(problem: LabellingProblem, known: PartialLabels, segment: int, frame: int) -> Control[bool]:
    """Identifies `segment` in the key-frame or after up to two shifts, or after correcting its parent; or abandons it.

    Our reading: the shifts of one segment do not move the key-frame of the next; identities are carried along the
    trajectories either way, and a recording would end before its segments do.
    """
    here = frame
    for shift in range(problem.settings.max_key_frame_shifts + 1):
        if shift:
            shifted = problem.later(here)
            if shifted == here:
                break
            here = shifted
            yield from recruit_incomplete(problem, known, here)
        match = yield from match_verified(problem, known, segment, here)
        if match is not None:
            accept(problem, known, match)
            return True
    if problem.model.segments[segment].parent != NO_PARENT:
        return (yield from correct_parent(problem, known, segment, frame))
    return False


def match_verified(
    problem: LabellingProblem,
    known: PartialLabels,
    segment: int,
    frame: int,
    use_joins: bool = True,
    banned: frozenset = frozenset(),
) -> Control[SegmentMatch | None]:
    """A match of `segment` in `frame` that its motion confirms, or None."""
    match = yield from match_segment(problem, known, segment, frame, use_joins, banned)
    if match is None:
        return None
    return (yield from verify(problem, known, match))


def verify(problem: LabellingProblem, known: PartialLabels, match: SegmentMatch) -> Control[SegmentMatch | None]:
    """Motion verification (section 4.3.1, Fig. 2): the same identities one relaxation interval later.

    Our reading: verified if Eq. 4 still holds in the later frame for the markers still seen, and at least three are;
    a segment of under three markers has no pose, its distances were tested over the whole window (Eq. 2). If
    recruitment at the later frame finds more than the key-frame had, the later match is preferred.
    """
    later = problem.later(match.frame)
    if later == match.frame or match.size < MIN_FIT_POINTS or problem.settings.method == "static":
        return match
    if problem.settings.method == "paper":
        later = _last_posed(problem, match, later)
    target = problem.targets[match.segment]
    alive = problem.trajectories.alive(later)
    found = np.where((match.trajectories != NO_MATCH) & alive[match.trajectories], match.trajectories, NO_MATCH)
    there = found != NO_MATCH
    if later == match.frame or there.sum() < MIN_FIT_POINTS:
        return None
    points = problem.trajectories.positions(np.array([later]), found)[0]
    _, residual, _ = yield from fit_one(target, points, there)
    if not (yield from mapping_error(target, residual, there)) < 1.0:
        return None
    if match.size == len(match.trajectories):
        return match
    grown = yield from _grow(problem, known, match.segment, later, found)
    if (grown != NO_MATCH).sum() > match.size:
        return SegmentMatch(match.segment, later, grown, match.error)
    return match


def _last_posed(problem: LabellingProblem, match: SegmentMatch, later: int) -> int:
    """The frame nearest to `later`, on the way there, that still shows three of a match's markers.

    Our reading: the paper fits a transformation in the later frame, which takes three. A marker that is hidden before
    says nothing against the match, so the motion up to there has to do. The full method, which asks many key-frames,
    does without a match that it cannot verify.
    """
    t, held = problem.trajectories, match.trajectories[match.trajectories != NO_MATCH]
    if later > match.frame:
        return min(later, int(np.sort(t.stop[held])[-MIN_FIT_POINTS]) - 1)
    return max(later, int(np.sort(t.start[held])[MIN_FIT_POINTS - 1]))


def accept(problem: LabellingProblem, known: PartialLabels, match: SegmentMatch) -> None:
    """Writes a match into what is known; whoever held one of its markers or trajectories before gives it up,
    but for what is given."""
    for marker, trajectory in zip(problem.targets[match.segment].markers, match.trajectories):
        if trajectory == NO_MATCH:
            continue
        clashes = known.clashes(problem, trajectory, marker)
        if not known.given[trajectory] and not (clashes & known.given).any():
            known.forget(clashes)
            known.identity[trajectory], known.recruited[trajectory] = marker, False
    known.found[match.segment] = True


def recruit_incomplete(problem: LabellingProblem, known: PartialLabels, frame: int) -> Control[None]:
    """Recruitment for every identified segment that lacks markers in `frame` (section 4.3.2)."""
    carrying = known.trajectory_of_marker(problem, frame)
    for segment in np.flatnonzero(known.found):
        target = problem.targets[segment]
        found = carrying[target.markers]
        grown = yield from _grow(problem, known, int(segment), frame, found)
        for k in np.flatnonzero(grown != found):
            if not known.clashes(problem, grown[k], target.markers[k]).any():
                known.recruit(grown[k], target.markers[k])
                carrying[target.markers[k]] = grown[k]


def _grow(
    problem: LabellingProblem, known: PartialLabels, segment: int, frame: int, found: np.ndarray
) -> Control[np.ndarray]:
    """Segment recruitment (Fig. 3): lost markers from the nearest unclaimed points, for as long as it grows.

    Our reading: nearest means one-to-one by the least total distance, so that no order of the markers matters.
    Returns the trajectory of each marker.
    """
    target = problem.targets[segment]
    found = found.copy()
    here, points = problem.at(frame)
    while True:
        there = found != NO_MATCH
        if there.all() or there.sum() < MIN_FIT_POINTS:
            return found
        places = problem.trajectories.positions(np.array([frame]), found)[0]
        predicted, _, posed = yield from fit_one(target, places, there)
        free = known.unclaimed(here)
        free[np.searchsorted(here, found[there])] = False
        free = np.flatnonzero(free)
        lost = np.flatnonzero(~there)
        if not posed or not len(free):
            return found
        near = np.linalg.norm(predicted[lost, None] - points[None, free], axis=-1)
        pairs = assign_within(near, target.reach[lost])
        if not pairs:
            return found
        for row, column in pairs:
            found[lost[row]] = here[free[column]]


def assign_within(distance: np.ndarray, reach: np.ndarray) -> list[tuple[int, int]]:
    """One-to-one pairs within reach, as many as there can be, at the least total distance."""
    allowed = distance <= reach[:, None]
    far = 1e6
    rows, columns = linear_sum_assignment(np.where(allowed, distance, far))
    return [(r, c) for r, c in zip(rows, columns) if allowed[r, c]]


def correct_parent(
    problem: LabellingProblem,
    known: PartialLabels,
    segment: int,
    frame: int,
    depth: int = 0,
    banned: frozenset = frozenset(),
) -> Control[bool]:
    """Recursive parent-segment correction (section 4.3.3, Fig. 4).

    Gives up the inherited join and tries all pivots. If that finds the segment and contradicts the parent's join, the
    parent is identified again without that join, and, where that fails, its own parent in turn. What was there is
    restored if nothing improves.
    """
    before = known.copy()
    target = problem.targets[segment]
    inherited = known.trajectories_of(problem, target.markers, frame)
    match = yield from match_verified(problem, known, segment, frame, use_joins=False, banned=banned)
    if match is None:
        known.restore(before)
        return False
    contradicted = (inherited != NO_MATCH) & (match.trajectories != inherited)
    accept(problem, known, match)
    parent = problem.model.segments[segment].parent
    if parent == NO_PARENT or not contradicted.any():
        return True
    wrong = frozenset((int(target.markers[k]), int(inherited[k])) for k in np.flatnonzero(contradicted))
    if (yield from _identify_again(problem, known, parent, frame, wrong)):
        return True
    if depth < len(problem.model.segments):
        if (yield from correct_parent(problem, known, parent, frame, depth + 1, wrong)):
            return True
    known.restore(before)
    return False


def _identify_again(
    problem: LabellingProblem, known: PartialLabels, segment: int, frame: int, banned: frozenset
) -> Control[bool]:
    """Identifies a segment afresh from the joins that it has now, without the pairs that proved wrong."""
    own = problem.prepared.owned[segment, known.identity]
    shared = _markers_of_others(problem, known, segment)
    known.forget(own & ~np.isin(known.identity, shared))
    match = yield from match_verified(problem, known, segment, frame, banned=banned)
    if match is None:
        return False
    accept(problem, known, match)
    return True


def _markers_of_others(problem: LabellingProblem, known: PartialLabels, segment: int) -> np.ndarray:
    """Markers that other identified segments hold too."""
    others = [problem.targets[s].markers for s in np.flatnonzero(known.found) if s != segment]
    return np.unique(np.concatenate(others)) if others else np.zeros(0, dtype=int)


def _drop_unconfirmed(problem: LabellingProblem, known: PartialLabels) -> None:
    """Segments of under three markers stay only if a child or grandchild is identified (section 4.2.2).

    Our reading: or their parent, as else no last segment of a chain could stay.
    """
    segments = problem.model.segments
    for segment in reversed(depth_first(segments)):
        if known.found[segment] and len(segments[segment].markers) < MIN_FIT_POINTS:
            below = children(segments, segment)
            below += [g for child in below for g in children(segments, child)]
            neighbours = [*below, segments[segment].parent]
            if not any(known.found[s] for s in neighbours if s != NO_PARENT):
                known.found[segment] = False
                mine = set(problem.targets[segment].markers) - set(_markers_of_others(problem, known, segment))
                known.forget(np.isin(known.identity, list(mine)))
