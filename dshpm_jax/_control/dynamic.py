"""The dynamic scheme over a key-frame range: match, verify, recruit, shift, correct, abandon (section 4.3, Fig. 1)."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from dshpm_jax._control.fitting import fit_one, mapping_error
from dshpm_jax._control.scene import Known, Scene
from dshpm_jax._control.segment import SegmentMatch, match_segment
from dshpm_jax._hierarchy import children, depth_first
from dshpm_jax._requests import Control
from dshpm_jax._types import MIN_FIT_POINTS, NO_MATCH, NO_PARENT


def key_frame(scene: Scene) -> int:
    """The first frame with enough of the model's markers, or the fullest (section 4.2)."""
    seen = (scene.trajectories.index != NO_MATCH).sum(1)
    full = np.flatnonzero(seen >= scene.settings.key_frame_coverage * scene.model.num_markers)
    return int(full[0]) if len(full) else int(np.argmax(seen))


def identify(scene: Scene, frame: int) -> Control:
    """Everything that can be identified in the key-frame range that begins at `frame` (Fig. 1).

    Segments are taken depth-first; those whose parent is not found wait until all other chains are done
    (section 4.4). Returns `Known`.
    """
    known = Known.nothing(scene)
    broken: list[int] = []
    segments = scene.model.segments
    for segment in depth_first(segments):
        parent = segments[segment].parent
        if parent != NO_PARENT and not known.found[parent]:
            broken.append(segment)
            continue
        yield from identify_segment(scene, known, segment, frame)
    for segment in broken:
        yield from identify_segment(scene, known, segment, frame)
    _drop_unconfirmed(scene, known)
    return known


def identify_segment(scene: Scene, known: Known, segment: int, frame: int) -> Control:
    """Identifies `segment` in the key-frame or after up to two shifts, or after correcting its parent; or abandons it.

    Our reading: the shifts of one segment do not move the key-frame of the next; identities are carried along the
    trajectories either way, and a recording would end before its segments do.
    """
    here = frame
    for shift in range(scene.settings.max_key_frame_shifts + 1):
        if shift:
            shifted = scene.later(here)
            if shifted == here:
                break
            here = shifted
            yield from recruit_incomplete(scene, known, here)
        match = yield from match_verified(scene, known, segment, here)
        if match is not None:
            accept(scene, known, match)
            return True
    if scene.model.segments[segment].parent != NO_PARENT:
        return (yield from correct_parent(scene, known, segment, frame))
    return False


def match_verified(
    scene: Scene, known: Known, segment: int, frame: int, use_joins: bool = True, banned: frozenset = frozenset()
) -> Control:
    """A match of `segment` in `frame` that its motion confirms, or None."""
    match = yield from match_segment(scene, known, segment, frame, use_joins, banned)
    if match is None:
        return None
    return (yield from verify(scene, known, match))


def verify(scene: Scene, known: Known, match: SegmentMatch) -> Control:
    """Motion verification (section 4.3.1, Fig. 2): the same identities one relaxation interval later.

    Our reading: verified if Eq. 4 still holds in the later frame for the markers still seen, and at least three are;
    a segment of under three markers has no pose, its distances were tested over the whole window (Eq. 2). If
    recruitment at the later frame finds more than the key-frame had, the later match is preferred.
    """
    later = scene.later(match.frame)
    if later == match.frame or match.size < MIN_FIT_POINTS or scene.settings.method == "static":
        return match
    if scene.settings.method == "paper":
        later = _last_posed(scene, match, later)
    target = scene.targets[match.segment]
    alive = scene.trajectories.alive(later)
    holder = np.where((match.holder != NO_MATCH) & alive[match.holder], match.holder, NO_MATCH)
    there = holder != NO_MATCH
    if later == match.frame or there.sum() < MIN_FIT_POINTS:
        return None
    points = scene.trajectories.positions(np.array([later]), holder)[0]
    known.fits += 1
    _, residual, _ = yield from fit_one(target, points, there)
    if not (yield from mapping_error(target, residual, there)) < 1.0:
        return None
    if match.size == len(match.holder):
        return match
    grown = yield from _grow(scene, known, match.segment, later, holder)
    if (grown != NO_MATCH).sum() > match.size:
        return SegmentMatch(match.segment, later, grown, match.error)
    return match


def _last_posed(scene: Scene, match: SegmentMatch, later: int) -> int:
    """The frame nearest to `later`, on the way there, that still shows three of a match's markers.

    Our reading: the paper fits a transformation in the later frame, which takes three. A marker that is hidden before
    says nothing against the match, so the motion up to there has to do. The full method, which asks many key-frames,
    does without a match that it cannot verify.
    """
    t, held = scene.trajectories, match.holder[match.holder != NO_MATCH]
    if later > match.frame:
        return min(later, int(np.sort(t.stop[held])[-MIN_FIT_POINTS]) - 1)
    return max(later, int(np.sort(t.start[held])[MIN_FIT_POINTS - 1]))


def accept(scene: Scene, known: Known, match: SegmentMatch) -> None:
    """Writes a match into what is known; whoever held one of its markers or trajectories before gives it up."""
    for marker, trajectory in zip(scene.targets[match.segment].markers, match.holder):
        if trajectory != NO_MATCH:
            known.identity[known.clashes(scene, trajectory, marker)] = NO_MATCH
            known.identity[trajectory], known.recruited[trajectory] = marker, False
    known.found[match.segment] = True


def recruit_incomplete(scene: Scene, known: Known, frame: int) -> Control:
    """Recruitment for every identified segment that lacks markers in `frame` (section 4.3.2)."""
    carriers = known.carriers(scene, frame)
    for segment in np.flatnonzero(known.found):
        target = scene.targets[segment]
        holder = carriers[target.markers]
        grown = yield from _grow(scene, known, int(segment), frame, holder)
        for k in np.flatnonzero(grown != holder):
            if not known.clashes(scene, grown[k], target.markers[k]).any():
                known.recruit(grown[k], target.markers[k])
                carriers[target.markers[k]] = grown[k]


def _grow(scene: Scene, known: Known, segment: int, frame: int, holder: np.ndarray) -> Control:
    """Segment recruitment (Fig. 3): lost markers from the nearest unclaimed points, for as long as it grows.

    Our reading: nearest means one-to-one by the least total distance, so that no order of the markers matters.
    Returns the trajectory of each marker.
    """
    target = scene.targets[segment]
    holder = holder.copy()
    here, points = scene.at(frame)
    while True:
        there = holder != NO_MATCH
        if there.all() or there.sum() < MIN_FIT_POINTS:
            return holder
        places = scene.trajectories.positions(np.array([frame]), holder)[0]
        known.fits += 1
        predicted, _, posed = yield from fit_one(target, places, there)
        free = known.identity[here] == NO_MATCH
        free[np.searchsorted(here, holder[there])] = False
        free = np.flatnonzero(free)
        lost = np.flatnonzero(~there)
        if not posed or not len(free):
            return holder
        near = np.linalg.norm(predicted[lost, None] - points[None, free], axis=-1)
        pairs = assign_within(near, target.reach[lost])
        if not pairs:
            return holder
        for row, column in pairs:
            holder[lost[row]] = here[free[column]]


def assign_within(distance: np.ndarray, reach: np.ndarray) -> list[tuple[int, int]]:
    """One-to-one pairs within reach, as many as there can be, at the least total distance."""
    allowed = distance <= reach[:, None]
    far = 1e6
    rows, columns = linear_sum_assignment(np.where(allowed, distance, far))
    return [(r, c) for r, c in zip(rows, columns) if allowed[r, c]]


def correct_parent(
    scene: Scene, known: Known, segment: int, frame: int, depth: int = 0, banned: frozenset = frozenset()
) -> Control:
    """Recursive parent-segment correction (section 4.3.3, Fig. 4).

    Gives up the inherited join and tries all pivots. If that finds the segment and contradicts the parent's join, the
    parent is identified again without that join, and, where that fails, its own parent in turn. What was there is
    restored if nothing improves.
    """
    before = known.copy()
    target = scene.targets[segment]
    inherited = known.holders(scene, target.markers, frame)
    match = yield from match_verified(scene, known, segment, frame, use_joins=False, banned=banned)
    if match is None:
        known.restore(before)
        return False
    contradicted = (inherited != NO_MATCH) & (match.holder != inherited)
    accept(scene, known, match)
    parent = scene.model.segments[segment].parent
    if parent == NO_PARENT or not contradicted.any():
        return True
    wrong = frozenset((int(target.markers[k]), int(inherited[k])) for k in np.flatnonzero(contradicted))
    if (yield from _identify_again(scene, known, parent, frame, wrong)):
        return True
    if depth < len(scene.model.segments) and (yield from correct_parent(scene, known, parent, frame, depth + 1, wrong)):
        return True
    known.restore(before)
    return False


def _identify_again(scene: Scene, known: Known, segment: int, frame: int, banned: frozenset) -> Control:
    """Identifies a segment afresh from the joins that it has now, without the pairs that proved wrong."""
    own = scene.body.owned[segment, known.identity]
    shared = _markers_of_others(scene, known, segment)
    known.identity[own & ~np.isin(known.identity, shared)] = NO_MATCH
    match = yield from match_verified(scene, known, segment, frame, banned=banned)
    if match is None:
        return False
    accept(scene, known, match)
    return True


def _markers_of_others(scene: Scene, known: Known, segment: int) -> np.ndarray:
    """Markers that other identified segments hold too."""
    others = [scene.targets[s].markers for s in np.flatnonzero(known.found) if s != segment]
    return np.unique(np.concatenate(others)) if others else np.zeros(0, dtype=int)


def _drop_unconfirmed(scene: Scene, known: Known) -> None:
    """Segments of under three markers stay only if a child or grandchild is identified (section 4.2.2).

    Our reading: or their parent, as else no last segment of a chain could stay.
    """
    segments = scene.model.segments
    for segment in reversed(depth_first(segments)):
        if known.found[segment] and len(segments[segment].markers) < MIN_FIT_POINTS:
            below = children(segments, segment)
            below += [g for child in below for g in children(segments, child)]
            neighbours = [*below, segments[segment].parent]
            if not any(known.found[s] for s in neighbours if s != NO_PARENT):
                known.found[segment] = False
                mine = set(scene.targets[segment].markers) - set(_markers_of_others(scene, known, segment))
                known.identity[np.isin(known.identity, list(mine))] = NO_MATCH
