"""Builds the segments of a model: which markers, what shape, how rigid, and how they hang together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import evenly_spaced, rigid_fit
from dshpm_jax._hierarchy import choose_root
from dshpm_jax._model import Segment, VirtualJoin
from dshpm_jax._model_building.body_parts import parts_of_each, recognised
from dshpm_jax._model_building.expectation import expected_spread
from dshpm_jax._model_building.naming import segment_names
from dshpm_jax._model_building.overlap import closeness, overlapping, spanning_tree
from dshpm_jax._model_building.partition import groups, name_factor, normalised_spread
from dshpm_jax._model_building.shapes import joint_centre, mean_shape
from dshpm_jax._model_building.statistics import DistanceStatistics
from dshpm_jax._model_building.templates import BY_NAMES, TEMPLATES, by_template
from dshpm_jax._model_building.tuning import TUNING, ModelTuning
from dshpm_jax._types import MIN_FIT_POINTS, NO_PARENT

RIGID_OBJECT = "object"  # the only segment of a thing that is rigid as a whole


@dataclass(frozen=True)
class SegmentPlan:
    """Which markers form which segment and what hangs from what, before any geometry."""

    names: list[str]
    markers: list[list[int]]
    parents: list[int]


def build_segments(
    names: Sequence[str],
    clips: Sequence[Float[np.ndarray, "frames markers 3"]],
    statistics: DistanceStatistics,
    segments: Mapping[str, Any] | None = None,
    template: str | None = None,
    rigid: Sequence[Sequence[int]] | None = None,
    tuning: ModelTuning = TUNING,
) -> tuple[Segment, ...]:
    """Segments from a file's mapping, a template, rigid groups, the motion, or the names, whichever is there first.

    Arguments:
        rigid: groups of markers that sit on one bone each, and cover all markers; joints are found from the motion.
    """
    if segments is not None:
        plan = _from_mapping(segments, names, statistics, tuning)
    elif rigid is not None:
        plan = _from_motion(names, statistics, tuning, rigid)
    elif template is not None:
        plan = _from_template(template, names, statistics, tuning)
    elif is_still(statistics, tuning):
        plan = _without_motion(names, clips, statistics, tuning)
    else:
        plan = _from_motion(names, statistics, tuning)
    plan = _split_large(plan, statistics.mean, tuning)
    expected = replace(statistics, spread=expected_spread(statistics, names, tuning))
    points = np.concatenate([clip[evenly_spaced(len(clip), tuning.shape_frames)] for clip in clips])
    return _geometry(plan, points, expected, tuning)


def is_still(statistics: DistanceStatistics, tuning: ModelTuning = TUNING) -> bool:
    """Whether hardly any pair of markers changes its distance."""
    spread = statistics.spread[np.triu_indices(len(statistics.spread), 1)]
    spread = spread[np.isfinite(spread)]
    return not len(spread) or float(np.quantile(spread, tuning.still_share)) < tuning.still_mm


def _from_motion(
    names: Sequence[str],
    statistics: DistanceStatistics,
    tuning: ModelTuning,
    rigid: Sequence[Sequence[int]] | None = None,
) -> SegmentPlan:
    spread = normalised_spread(statistics, names, tuning)
    found = groups(spread, names, tuning) if rigid is None else rigid
    markers, links = overlapping(found, spread, parts_of_each(names), tuning)
    return SegmentPlan(segment_names(markers, names), markers, _parents(markers, links))


def _without_motion(
    names: Sequence[str],
    clips: Sequence[Float[np.ndarray, "frames markers 3"]],
    statistics: DistanceStatistics,
    tuning: ModelTuning,
) -> SegmentPlan:
    known = recognised(names)
    if known < tuning.known_names and any(_turns(clip, tuning) for clip in clips):
        return SegmentPlan([RIGID_OBJECT], [list(range(len(names)))], [NO_PARENT])
    if known < tuning.known_names:
        raise ValueError(
            f"the recordings show too little motion to find segments, and only {known:.0%} of the marker names are "
            "known; add a recording in which every joint moves, or give the segments in a file"
        )
    return _from_template(BY_NAMES, names, statistics, tuning)


def _turns(clip: Float[np.ndarray, "frames markers 3"], tuning: ModelTuning) -> bool:
    """Whether something turns over as a whole, as an object in a hand does and nobody who stands still."""
    some = clip[evenly_spaced(len(clip), tuning.shape_frames)]
    rotations, _ = rigid_fit(some[0], some)
    cosine = (np.trace(rotations, axis1=1, axis2=2) - 1.0) / 2.0
    angles = np.degrees(np.arccos(np.clip(cosine[np.isfinite(cosine)], -1.0, 1.0)))
    return bool(len(angles)) and float(angles.max()) > tuning.object_turn_degrees


def _from_template(
    template: str, names: Sequence[str], statistics: DistanceStatistics, tuning: ModelTuning
) -> SegmentPlan:
    found = by_template(names, template)
    if not found:
        raise ValueError(
            f"the template {template!r} knows none of the markers {_few(names)}; give the segments in a file, or one "
            f"of the templates {', '.join(sorted(TEMPLATES))}"
        )
    covered = {m for markers in found.values() for m in markers}
    for marker in sorted(set(range(len(names))) - covered):
        _nearest(found, marker, statistics.mean).append(marker)
    parts = [part for part, markers in found.items() if not any(set(markers) < set(o) for o in found.values())]
    markers = [sorted(found[part]) for part in parts]
    return SegmentPlan(parts, markers, _parents(markers, _nearest_tree(markers, names, statistics, tuning)))


def _nearest(found: dict[str, list[int]], marker: int, distance: np.ndarray) -> list[int]:
    """The segment with the nearest marker."""
    far = np.nan_to_num(distance[marker], nan=np.inf)
    return min(found.values(), key=lambda markers: min(far[m] for m in markers))


def _from_mapping(
    segments: Mapping[str, Any], names: Sequence[str], statistics: DistanceStatistics, tuning: ModelTuning
) -> SegmentPlan:
    place = {name: i for i, name in enumerate(names)}
    labels = {name: list(entry["markers"]) for name, entry in segment_entries(segments).items()}
    unknown = sorted({label for found in labels.values() for label in found} - place.keys())
    if unknown:
        raise ValueError(
            f"the segments name markers that the recordings do not have: {_few(unknown)}; they have {_few(names)}"
        )
    left = sorted(set(names) - {label for found in labels.values() for label in found})
    if left:
        raise ValueError(f"no segment holds {_few(left)}; put every marker in at least one segment")
    markers = [sorted({place[label] for label in found}) for found in labels.values()]
    parents = _parents(markers, _nearest_tree(markers, names, statistics, tuning))
    given = [entry.get("parent") for entry in segment_entries(segments).values()]
    if any(given):
        parents = _given_parents(list(labels), given)
    return SegmentPlan(list(labels), markers, parents)


def segment_entries(segments: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """The mapping with every value as `{"markers": [...], "parent": ...}`; a bare list is the markers."""
    entries = {}
    for name, entry in segments.items():
        entry = entry if isinstance(entry, Mapping) else {"markers": entry}
        markers = entry.get("markers")
        if isinstance(markers, str) or not isinstance(markers, Sequence) or not len(markers):
            raise ValueError(f"segment {name!r} needs a list of one or more marker names in 'markers', got {markers!r}")
        entries[str(name)] = entry
    if not entries:
        raise ValueError("no segments were given; expected a mapping of segment names to lists of markers")
    return entries


def _given_parents(names: list[str], given: Sequence[str | None]) -> list[int]:
    """Parents by name; exactly one segment has none, and every chain ends there."""
    unknown = sorted({parent for parent in given if parent and parent not in names})
    if unknown:
        raise ValueError(f"unknown parent segments {_few(unknown)}; the segments are {_few(names)}")
    parents = [names.index(parent) if parent else NO_PARENT for parent in given]
    roots = [name for name, parent in zip(names, parents) if parent == NO_PARENT]
    if len(roots) != 1:
        raise ValueError(f"exactly one segment may have no parent, got {len(roots)}: {_few(roots) or 'none'}")
    for s in range(len(parents)):
        here, steps = s, 0
        while here != NO_PARENT and steps <= len(parents):
            here, steps = parents[here], steps + 1
        if steps > len(parents):
            raise ValueError(f"the parents of segment {names[s]!r} go round in a circle; the chain must reach a root")
    return parents


def _few(names: Sequence[str], most: int = 8) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def _nearest_tree(
    markers: Sequence[Sequence[int]], names: Sequence[str], statistics: DistanceStatistics, tuning: ModelTuning
) -> list[list[int]]:
    """The tree over given segments: those that share markers first, then near ones whose names say that they meet."""
    far = np.nan_to_num(statistics.mean, nan=np.nanmax(statistics.mean, initial=1.0))
    return spanning_tree(closeness(markers, far * name_factor(names, tuning), tuning))


def _parents(markers: Sequence[Sequence[int]], links: Sequence[Sequence[int]]) -> list[int]:
    """Parents of a tree that hangs from the paper's choice of root (section 4.4)."""
    root = choose_root([len(m) for m in markers], links)
    parents = [NO_PARENT] * len(markers)
    waiting, seen = [root], {root}
    while waiting:
        here = waiting.pop()
        for near in links[here]:
            if near not in seen:
                parents[near] = here
                seen.add(near)
                waiting.append(near)
    return parents


def _split_large(plan: SegmentPlan, distance: np.ndarray, tuning: ModelTuning) -> SegmentPlan:
    """Segments of more than `max_group` markers in overlapping strips, each hanging from the one before.

    The strips lie between the two markers that are furthest apart; a few markers at each border are in both.
    """
    names, markers, parents = list(plan.names), [list(m) for m in plan.markers], list(plan.parents)
    for s, whole in enumerate(plan.markers):
        if len(whole) <= tuning.max_group:
            continue
        inside = np.asarray(whole)
        far = np.nan_to_num(distance[np.ix_(inside, inside)])
        one, other = np.unravel_index(int(np.argmax(far)), far.shape)
        order = inside[np.argsort(far[one] - far[other], kind="stable")]
        starts = range(0, len(order) - tuning.split_shares, tuning.max_group - tuning.split_shares)
        strips = [sorted(int(m) for m in order[start : start + tuning.max_group]) for start in starts]
        markers[s], before = strips[0], s
        for k, strip in enumerate(strips[1:], 2):
            names.append(f"{names[s]} {k}")
            parents.append(before)
            before = len(markers)
            markers.append(strip)
    return SegmentPlan(names, markers, parents)


def _geometry(
    plan: SegmentPlan, points: np.ndarray, statistics: DistanceStatistics, tuning: ModelTuning
) -> tuple[Segment, ...]:
    """Shapes, poses over the recordings, joins and rigidity of the planned segments."""
    shapes = [mean_shape(points[:, m], statistics.mean[np.ix_(m, m)], tuning) for m in plan.markers]
    segments = []
    for s, markers in enumerate(plan.markers):
        parent = plan.parents[s]
        shared = () if parent == NO_PARENT else tuple(sorted(set(markers) & set(plan.markers[parent])))
        ratio = _distortion_ratio(markers, statistics, tuning)
        segments.append(
            Segment(
                name=plan.names[s],
                markers=tuple(markers),
                shape=shapes[s],
                parent=parent,
                join=shared,
                virtual_join=_virtual_join(plan, s, shapes, points, statistics, tuning),
                distortion_ratio=ratio,
                matching_quantity=_matching_quantity(ratio, tuning),
            )
        )
    return tuple(segments)


def _virtual_join(
    plan: SegmentPlan,
    s: int,
    shapes: Sequence[np.ndarray],
    points: np.ndarray,
    statistics: DistanceStatistics,
    tuning: ModelTuning,
) -> VirtualJoin | None:
    """The centre of the joint with the parent, drawn towards the middle of the nearest markers of the two."""
    parent = plan.parents[s]
    if parent == NO_PARENT or min(len(plan.markers[s]), len(plan.markers[parent])) < MIN_FIT_POINTS:
        return None
    poses, guesses = [], []
    for here, there in ((parent, s), (s, parent)):
        markers = plan.markers[here]
        far = np.nan_to_num(statistics.mean[np.ix_(markers, plan.markers[there])], nan=np.inf).min(1)
        guesses.append(shapes[here][np.argsort(far, kind="stable")[: tuning.nearest_to_joint]].mean(0))
        # A marker of both gives a little with each of them, so the poses rest on the others where these suffice.
        own = [k for k, marker in enumerate(markers) if marker not in plan.markers[there]]
        own = own if len(own) >= MIN_FIT_POINTS else list(range(len(markers)))
        poses.append(rigid_fit(shapes[here][own], points[:, [markers[k] for k in own]]))
    in_parent, in_segment, spread = joint_centre(poses[0], poses[1], guesses[0], guesses[1], tuning)
    return VirtualJoin(in_parent, in_segment, spread) if spread <= tuning.max_joint_spread_mm else None


def _distortion_ratio(markers: Sequence[int], statistics: DistanceStatistics, tuning: ModelTuning) -> float:
    """Allowed relative change of a pair distance: a multiple of the typical spread, within the paper's range."""
    rows, columns = np.triu_indices(len(markers), 1)
    index = np.asarray(markers)
    mean, spread = (values[index[rows], index[columns]] for values in (statistics.mean, statistics.spread))
    seen = np.isfinite(spread) & (mean > 0)
    if not seen.any():
        return Segment.distortion_ratio
    ratio = tuning.distortion_factor * np.sqrt((spread[seen] ** 2).mean()) / mean[seen].mean()
    return float(np.clip(ratio, tuning.ratio_low, tuning.ratio_high))


def _matching_quantity(ratio: float, tuning: ModelTuning) -> float:
    """The share of its markers that a match of a segment must hold, more the looser it is, within the paper's range."""
    ends = (tuning.ratio_low, tuning.ratio_high), (tuning.quantity_low, tuning.quantity_high)
    return float(np.interp(ratio, *ends))
