"""A picture of identified figures, a few frames side by side, as in Fig. 6 of the paper."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.distance import cdist

from dshpm_jax._geometry import evenly_inside, is_seen
from dshpm_jax._hierarchy import depth_first
from dshpm_jax._labelling import Labelling
from dshpm_jax._model import Segment
from dshpm_jax._trajectories import by_marker
from dshpm_jax._types import NO_MATCH
from dshpm_jax.report._looks import COLOURS, shortest_tree, upward

FIGURES = 7  # shown unless frames are given
ELEVATION = 12.0  # degrees from which we look down
ASIDE = 25.0  # degrees off the widest view, so that limbs do not hide each other
GAP = 190.0  # between neighbouring figures (mm)
WIDTH = 17.0  # of the picture (inches)
GREY, SHADOW, INK = "#adb5bd", "#eef0f2", "#343a40"


class Pane(NamedTuple):
    """One frame of the picture.

    Attributes:
        frame: which one.
        markers: places in the room (mm), NaN where not identified.
        others: points without a label (mm).
    """

    frame: int
    markers: Float[np.ndarray, "markers 3"]
    others: Float[np.ndarray, "points 3"]


class View(NamedTuple):
    """How the room is seen: two axes in the plane of the picture, one towards us, and the vertical of the room."""

    right: Float[np.ndarray, "3"]
    top: Float[np.ndarray, "3"]
    near: Float[np.ndarray, "3"]
    vertical: Float[np.ndarray, "3"]

    def flat(self, points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 2"]:
        """Places in the plane of the picture (mm)."""
        return points @ np.stack([self.right, self.top], -1)


def figures_png(labelling: Labelling, path: Path | str, frames: Sequence[int] | None = None) -> None:
    """Draws the identified figure in some frames side by side, all on one ground.

    The markers of a segment are linked in its own colour; points without a label are small grey crosses, left out where
    they are further from the figure than its neighbours.

    Arguments:
        labelling: what to draw.
        path: the PNG file to write.
        frames: which frames, from 0; by default some that are spread over the recording.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as missing:
        raise ModuleNotFoundError("pictures need matplotlib: pip install 'dshpm-jax[pictures]'") from missing
    panes = _panes(labelling, _frames(labelling, frames))
    view = _view(panes)
    ground = min((float((p.markers[_seen(p)] @ view.vertical).min()) for p in panes if _seen(p).any()), default=0.0)
    picture = Figure(figsize=(WIDTH, WIDTH / 3), dpi=130, facecolor="white")
    axes = picture.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_aspect("equal")
    at = 0.0
    for pane in panes:
        at = _draw_pane(axes, labelling, pane, view, ground, at) + GAP
    _legend(axes, labelling)
    picture.savefig(path, bbox_inches="tight", pad_inches=0.25)


def _frames(labelling: Labelling, frames: Sequence[int] | None) -> list[int]:
    """The frames to show, checked or chosen."""
    count = labelling.recording.num_frames
    if frames is None:
        return evenly_inside(count, FIGURES).tolist()
    if any(not 0 <= t < count for t in frames):
        raise ValueError(f"got the frames {list(frames)}: the recording has frames 0 to {count - 1}")
    return list(frames)


def _panes(labelling: Labelling, frames: Sequence[int]) -> list[Pane]:
    identities, points = labelling.identities, labelling.recording.points
    found = []
    for t in frames:
        markers = by_marker(points[t], identities[t], labelling.model.num_markers)
        others = (identities[t] == NO_MATCH) & is_seen(points[t])
        found.append(Pane(t, markers, points[t, others]))
    return found


def _seen(pane: Pane) -> Bool[np.ndarray, "markers"]:
    return np.isfinite(pane.markers[:, 0])


def _view(panes: Sequence[Pane]) -> View:
    """Looks at the broad side of the shown figures, a little from aside and from above."""
    clouds = [pane.markers[_seen(pane)] for pane in panes if _seen(pane).any()]
    vertical = upward(clouds)
    cloud = np.concatenate([c - c.mean(0) for c in clouds]) if clouds else np.zeros((1, 3))
    cloud = cloud - np.outer(cloud @ vertical, vertical)
    wide = np.linalg.svd(cloud)[2][0]
    wide = wide - vertical * (wide @ vertical)
    if np.linalg.norm(wide) < 0.5:  # nothing spreads sideways: any horizontal direction serves
        wide = np.roll(vertical, 1)
    wide /= np.linalg.norm(wide)
    aside, above = np.deg2rad(ASIDE), np.deg2rad(ELEVATION)
    right = np.cos(aside) * wide + np.sin(aside) * np.cross(vertical, wide)
    front = np.cross(right, vertical)
    top = np.cos(above) * vertical - np.sin(above) * front
    return View(right, top, np.cross(right, top), vertical)


def _draw_pane(axes, labelling: Labelling, pane: Pane, view: View, ground: float, left: float) -> float:
    """Draws one figure with its left edge at `left` (mm) and gives its right edge."""
    seen = _seen(pane)
    middle = pane.markers[seen].mean(0) if seen.any() else np.zeros(3)
    # the camera goes along with the figure over the ground, never up and down with it
    origin = middle + view.vertical * (ground - middle @ view.vertical)
    markers, others = pane.markers - origin, pane.others - origin
    flat = view.flat(markers[seen]) if seen.any() else np.array([[-200.0, 0.0], [200.0, 0.0]])
    (low, _), (high, top) = flat.min(0), flat.max(0)
    shift = np.array([left - low, 0.0])
    _draw_shadow(axes, markers[seen], view, shift)
    _draw_others(axes, view.flat(others) + shift, (left - GAP / 2, left + high - low + GAP / 2), (0.0, top + GAP))
    _draw_segments(axes, labelling.model.segments, markers, view, shift)
    _caption(axes, labelling, pane, left + (high - low) / 2)
    return float(left + high - low)


def _draw_shadow(axes, markers: Float[np.ndarray, "markers 3"], view: View, shift) -> None:
    """The outline of the figure on the ground, which tells a jump from a step."""
    fallen = view.flat(markers - np.outer(markers @ view.vertical, view.vertical)) + shift
    outline = _outline(fallen)
    if len(outline):
        axes.fill(*fallen[outline].T, color=SHADOW, linewidth=0, zorder=0)


def _draw_others(
    axes, flat: Float[np.ndarray, "points 2"], wide: tuple[float, float], high: tuple[float, float]
) -> None:
    inside = (flat >= (wide[0], high[0])).all(-1) & (flat <= (wide[1], high[1])).all(-1)
    axes.plot(*flat[inside].T, "x", color=GREY, markersize=3.5, markeredgewidth=0.9, zorder=1)


def _draw_segments(axes, segments: Sequence[Segment], markers, view: View, shift) -> None:
    """Links the markers of each segment, the nearest segment last."""
    colours = _colours(segments)
    flat = view.flat(markers) + shift
    depth = markers @ view.near
    for s, segment in enumerate(segments):
        held = [k for k, m in enumerate(segment.markers) if np.isfinite(depth[m])]
        if not held:
            continue
        places = flat[[segment.markers[k] for k in held]]
        order = 2 + (np.mean(depth[[segment.markers[k] for k in held]]) + 5000) / 10000
        outline = _outline(places)
        if len(outline):
            axes.fill(*places[outline].T, color=colours[s], alpha=0.2, linewidth=0, zorder=order)
        links = shortest_tree(cdist(segment.shape[held], segment.shape[held])) + [
            (int(i), int(j)) for i, j in zip(outline, np.roll(outline, -1), strict=True)
        ]
        for link in links:
            axes.plot(*places[list(link)].T, color=colours[s], linewidth=1.6, solid_capstyle="round", zorder=order)
        axes.plot(
            *places.T, "o", color=colours[s], markersize=3.6, markeredgecolor="white", markeredgewidth=0.5, zorder=order
        )


def _outline(places: Float[np.ndarray, "n 2"]) -> Int[np.ndarray, "k"]:
    """Corners of the convex outline, in order round it; none for fewer than three places or for places in a line."""
    if len(places) < 3:
        return np.zeros(0, dtype=int)
    try:
        return ConvexHull(places).vertices
    except QhullError:
        return np.zeros(0, dtype=int)


def _colours(segments: Sequence[Segment]) -> dict[int, str]:
    return {s: COLOURS[k % len(COLOURS)] for k, s in enumerate(depth_first(segments))}


def _caption(axes, labelling: Labelling, pane: Pane, x: float) -> None:
    seen = int(_seen(pane).sum())
    seconds = pane.frame / labelling.recording.rate
    put = {"ha": "center", "va": "top", "textcoords": "offset points"}
    axes.annotate(f"{seconds:.2f} s", (x, 0), (0, -28), color=INK, fontsize=12, weight="bold", **put)
    below = f"frame {pane.frame}\n{seen} of {labelling.model.num_markers} markers"
    axes.annotate(below, (x, 0), (0, -44), color=INK, fontsize=9, linespacing=1.5, **put)


def _legend(axes, labelling: Labelling) -> None:
    """The colour of each segment, and what a cross means, under the figures."""
    from matplotlib.lines import Line2D

    segments = labelling.model.segments
    marks = [
        Line2D(
            [],
            [],
            color=colour,
            marker="o",
            linewidth=2.5,
            markersize=5,
            markeredgecolor="white",
            label=segments[s].name,
        )
        for s, colour in _colours(segments).items()
    ]
    marks.append(Line2D([], [], color=GREY, marker="x", linestyle="none", markersize=5, label="unlabelled"))
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.19), "ncols": min(8, len(marks))}
    axes.legend(handles=marks, frameon=False, fontsize=9.5, labelcolor=INK, columnspacing=2.0, **place)
