"""A film as the data of its page: coordinates as 16-bit steps, turned so that the third axis points up."""

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._geometry import evenly_spaced, is_seen
from dshpm_jax.report._film import Film, Span
from dshpm_jax.report._links import Link, Part
from dshpm_jax.report._looks import COLOURS, upward
from dshpm_jax.report._sides import sides

STEPS = 32767
MISSING = -32768
MIN_STEP, MAX_STEP = 0.1, 1.0  # mm
CAMERA_SECONDS = 0.6  # over which the camera's path is smoothed
SAMPLED_FRAMES = 50
ASIDE = np.deg2rad(25)  # off the widest view, so that limbs do not hide each other


def player_data(film: Film, name: str) -> dict[str, Any]:
    """What the page's script works on. The last column of its points is the path of the camera's target."""
    named = film.points[:, : len(film.names)]
    figure = named if is_seen(named).any() else film.points
    room, steps = room_data(film.points, figure, film.names, film.rate)
    reasons = list(dict.fromkeys(span.reason for span in (*film.spans, *film.doubts)))
    return {
        **room,
        "name": name,
        "names": film.names,
        "points": base64.b64encode(steps.tobytes()).decode(),
        **parts_data(film.parts, film.links),
        "reasons": reasons,
        "spans": [_listed(span, reasons) for span in film.spans],
        "doubts": [_listed(span, reasons) for span in film.doubts],
        "troubles": film.troubles,
        "notes": film.notes,
    }


def room_data(
    points: Float[np.ndarray, "frames columns 3"],
    figure: Float[np.ndarray, "frames markers 3"],
    names: Sequence[str],
    rate: float,
) -> tuple[dict[str, Any], Int[np.ndarray, "frames columns+1 3"]]:
    """How points are laid out and looked at, and the points themselves as 16-bit steps; `axes` are in which order.

    Arguments:
        points: what is shown (mm), NaN where there is none; the path of the camera's target comes behind.
        figure: what the camera looks at.
        names: of the columns of `figure`, where it has names.
    """
    turn = _up_last(figure, [name.rpartition(":")[0] for name in names])
    points, figure = points[:, :, turn], figure[:, :, turn]
    camera = _camera(figure, rate)
    near = is_seen(figure)
    distance = np.linalg.norm(figure - camera[:, None], axis=-1)[near]
    steps, step, centre = _packed(np.concatenate([points, camera[:, None]], axis=1))
    room = {
        "rate": rate,
        "frames": len(points),
        "columns": points.shape[1] + 1,
        "axes": turn,
        "step": step,
        "centre": centre,
        "floor": float(np.quantile(figure[near][:, 2], 0.002)),
        "height": float(np.median(camera[:, 2])),
        "radius": float(max(np.quantile(distance, 0.95), 50.0)),
        "yaw": _yaw(figure, camera),
        "sides": sides(names),
    }
    return room, steps


def parts_data(parts: Sequence[Part], links: Sequence[Link]) -> dict[str, Any]:
    """Segments with their colours, and sticks."""
    coloured = [
        {"name": part.name, "columns": part.columns, "colour": COLOURS[k % len(COLOURS)]}
        for k, part in enumerate(parts)
    ]
    return {"parts": coloured, "links": links}


def _listed(span: Span, reasons: list[str]) -> list[Any]:
    place = [span.column, span.first, span.last]
    return [*place, round(span.confidence, 3), reasons.index(span.reason), int(span.doubtful)]


def _up_last(figure: Float[np.ndarray, "frames markers 3"], subjects: Sequence[str]) -> list[int]:
    """The order of the axes in which the one that points up comes last, none mirrored.

    Each subject is judged by itself, as two people may stand far apart; without names all points are one.
    """
    some = figure[evenly_spaced(len(figure), SAMPLED_FRAMES)]
    each = np.array(subjects if len(subjects) == figure.shape[1] else [""] * figure.shape[1])
    clouds = [frame[is_seen(frame)] for name in sorted(set(each)) for frame in some[:, each == name]]
    up = int(np.argmax(upward([cloud for cloud in clouds if len(cloud)])))
    return [(up + 1) % 3, (up + 2) % 3, up]


def _camera(figure: Float[np.ndarray, "frames markers 3"], rate: float) -> Float[np.ndarray, "frames 3"]:
    """The middle of the figure in every frame, smoothed, so that it follows no single marker."""
    seen = is_seen(figure)
    held = np.flatnonzero(seen.any(1))
    middle = np.stack([np.nanmedian(np.where(seen[held, :, None], figure[held], np.nan)[..., k], 1) for k in range(3)])
    everywhere = np.stack([np.interp(np.arange(len(figure)), held, axis) for axis in middle], axis=-1)
    half = round(CAMERA_SECONDS * rate / 2)
    padded = np.pad(everywhere, ((half, half), (0, 0)), mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0).mean(-1)


def _yaw(figure: Float[np.ndarray, "frames markers 3"], camera: Float[np.ndarray, "frames 3"]) -> float:
    """The turn about the vertical (radians) that shows the figure from its broad side, a little from aside."""
    frames = evenly_spaced(len(figure), SAMPLED_FRAMES)
    around = (figure - camera[:, None])[frames][is_seen(figure[frames])][:, :2]
    _, axes = np.linalg.eigh(around.T @ around)
    wide = axes[:, 1] * np.sign(axes[0, 1] or 1)
    return float(ASIDE - np.arctan2(wide[1], wide[0]))


def _packed(points: Float[np.ndarray, "frames columns 3"]) -> tuple[Int[np.ndarray, "frames columns 3"], float, list]:
    """The points as 16-bit steps from a centre, the step and the centre (mm).

    Steps are no finer than `MIN_STEP`, and no coarser than `MAX_STEP`: a point further off is shown at the edge.
    """
    seen = is_seen(points)
    places = points[seen]
    centre = np.median(places, axis=0)
    step = float(np.clip(np.abs(places - centre).max() / STEPS, MIN_STEP, MAX_STEP))
    steps = np.full(points.shape, MISSING, dtype="<i2")
    steps[seen] = np.clip(np.round((places - centre) / step), -STEPS, STEPS)
    return steps, step, centre.tolist()
