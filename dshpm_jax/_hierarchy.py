"""Walks over the tree of segments (section 4.4)."""

from collections.abc import Sequence

from dshpm_jax._model import Segment
from dshpm_jax._types import NO_PARENT


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
