"""Segments, joins and the tree over them (section 3.1 and 4.4); plain numpy."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from dshpm_jax._types import NO_PARENT


@dataclass(frozen=True, eq=False)
class VirtualJoin:
    """The centre of the joint between a segment and its parent, a point that nobody sees.

    Attributes:
        in_parent: its place in the frame of the parent's `shape` (mm).
        in_segment: its place in the frame of the segment's own `shape` (mm).
        spread: root mean square distance of the two places over the model's recordings (mm).
    """

    in_parent: Float[np.ndarray, "3"]
    in_segment: Float[np.ndarray, "3"]
    spread: float


@dataclass(frozen=True, eq=False)
class Segment:
    """A nearly rigid group of markers, P_s of the paper.

    Attributes:
        name: what people call it.
        markers: identities, ascending; a marker may belong to several segments (then it is a join point).
        shape: mean places of the markers in a frame of the segment's own, centred (mm), a row for each of `markers`.
        parent: the segment it hangs from, `NO_PARENT` for the root.
        join: identities shared with the parent, may be empty.
        virtual_join: centre of the joint with the parent, where the model's recordings show one.
        distortion_ratio: allowed relative change of a pair distance (Eqs. 1 to 4), no unit.
        matching_quantity: share of the markers that a match must hold (Eq. 5), no unit.
    """

    name: str
    markers: tuple[int, ...]
    shape: Float[np.ndarray, "segment_markers 3"]
    parent: int = NO_PARENT
    join: tuple[int, ...] = ()
    virtual_join: VirtualJoin | None = None
    distortion_ratio: float = 0.1
    matching_quantity: float = 0.8


def children(segments: Sequence[Segment], parent: int) -> list[int]:
    """Segments that hang from `parent`, the one with the most markers first (section 4.4), ties by index."""
    found = [s for s, segment in enumerate(segments) if segment.parent == parent]
    return sorted(found, key=lambda s: (-len(segments[s].markers), s))


def depth_first(segments: Sequence[Segment]) -> list[int]:
    """Every segment, the root first, then chain by chain (section 4.4)."""
    return [s for root in children(segments, NO_PARENT) for s in subtree(segments, root)]


def subtree(segments: Sequence[Segment], segment: int) -> list[int]:
    """The segment and all that hangs from it, parents before children."""
    order: list[int] = []
    waiting = [segment]
    while waiting:
        here = waiting.pop()
        order.append(here)
        waiting += children(segments, here)[::-1]
    return order


def choose_root(sizes: Sequence[int], links: Sequence[Sequence[int]]) -> int:
    """The segment with the most markers and links.

    Our reading: the paper wants a root that has more points and more segments linked to it than most others; we take
    the largest sum of both, a link counting as three points (so that the trunk wins over a shank full of markers), then
    the more linked, then the lower index.
    """
    return max(range(len(sizes)), key=lambda s: (sizes[s] + 3 * len(links[s]), len(links[s]), -s))
