"""An articulated figure: bones, markers on soft tissue, and what a capture system sees of them."""

from dataclasses import dataclass
from typing import NamedTuple, TypedDict

import numpy as np
from jaxtyping import Float

from dshpm_jax._recording import Recording
from dshpm_jax._types import NO_PARENT
from dshpm_jax.synthesis._curves import smooth

GRAVITY = 9810.0  # mm/s^2, the scale on which accelerations shake soft tissue
SHAKING_TURN = 4.0  # rad/s, the scale on which turning shakes it
TREMOR_HERTZ = 3.0  # the fastest that soft tissue swings


class FigureBone(NamedTuple):
    """A rigid segment; its frame sits in the joint with its parent and is the world's in the neutral pose.

    `offset` is the joint's place in the parent's frame (mm).
    """

    name: str
    parent: int
    offset: tuple[float, float, float]


class Marker(NamedTuple):
    """A marker at `place` in the frame of `bone` (mm).

    `softness` bounds how far it slides on the bone (mm). With `shared`, it sits over the joint of `bone` with its
    parent and belongs to both segments (a join point): like skin there, it goes half with the one, half with the other.
    """

    name: str
    bone: int
    place: tuple[float, float, float]
    softness: float = 0.0
    shared: bool = False


class SegmentNames(TypedDict):
    """A segment by the names of its markers and of its parent (`None` for the root)."""

    markers: tuple[str, ...]
    parent: str | None


@dataclass(frozen=True, eq=False)
class Figure:
    """Bones, parents before children, and the markers on them."""

    bones: tuple[FigureBone, ...]
    markers: tuple[Marker, ...]

    def segments(self) -> dict[str, SegmentNames]:
        """Every segment by name, with its own markers and those that it shares."""
        found: dict[str, SegmentNames] = {}
        for b, bone in enumerate(self.bones):
            below = {k for k, other in enumerate(self.bones) if other.parent == b}
            names = tuple(m.name for m in self.markers if m.bone == b or (m.shared and m.bone in below))
            found[bone.name] = {
                "markers": names,
                "parent": None if bone.parent == NO_PARENT else self.bones[bone.parent].name,
            }
        return found


@dataclass(frozen=True, eq=False)
class Synthetic:
    """A recording of a made figure, with the truth behind it.

    Attributes:
        recording: every marker labelled, in every frame.
        segments: for each segment its markers and its parent, by name; the root's parent is `None`.
        rotations: from each segment's frame to the world, in the order of `segments`.
        positions: origins of the segments' frames (mm), the joints with their parents.
    """

    recording: Recording
    segments: dict[str, SegmentNames]
    rotations: Float[np.ndarray, "frames segments 3 3"]
    positions: Float[np.ndarray, "frames segments 3"]


def pose(
    figure: Figure, relative: Float[np.ndarray, "frames segments 3 3"], root: Float[np.ndarray, "frames 3"]
) -> tuple[Float[np.ndarray, "frames segments 3 3"], Float[np.ndarray, "frames segments 3"]]:
    """Rotations and joint positions (mm) in the world, from rotations relative to the parents and the root's place."""
    turned = relative.copy()
    positions = np.empty(relative.shape[:3])
    for b, bone in enumerate(figure.bones):
        if bone.parent == NO_PARENT:
            positions[:, b] = root
            continue
        turned[:, b] = turned[:, bone.parent] @ relative[:, b]
        positions[:, b] = positions[:, bone.parent] + turned[:, bone.parent] @ np.array(bone.offset)
    return turned, positions


def capture(
    figure: Figure,
    relative: Float[np.ndarray, "frames segments 3 3"],
    root: Float[np.ndarray, "frames 3"],
    rate: float,
    noise: float,
    body: np.random.Generator,
    rng: np.random.Generator,
) -> Synthetic:
    """What a capture system sees of `figure` in motion.

    Arguments:
        relative: rotations of the segments relative to their parents.
        root: the place of the root's origin (mm).
        noise: standard deviation of a measured coordinate (mm).
        body: draws what stays with the subject, `rng` what belongs to the take.
    """
    turned, positions = pose(figure, relative, root)
    slides = _soft_tissue(figure, relative, turned, positions, rate, body, rng)
    points = np.stack(
        [_place(figure, m, turned, positions, slides[:, k]) for k, m in enumerate(figure.markers)], axis=1
    )
    points += rng.normal(0.0, noise, points.shape)
    recording = Recording(points, tuple(m.name for m in figure.markers), rate)
    return Synthetic(recording, figure.segments(), turned, positions)


def _place(figure: Figure, marker: Marker, turned, positions, slide) -> Float[np.ndarray, "frames 3"]:
    """The marker's path in the world (mm); `slide` is in the frame of its bone."""
    b = marker.bone
    local = np.array(marker.place) + slide
    arm = np.einsum("tij,tj->ti", turned[:, b], local)
    if marker.shared:
        arm = (arm + np.einsum("tij,tj->ti", turned[:, figure.bones[b].parent], local)) / 2
    return positions[:, b] + arm


def _soft_tissue(figure: Figure, relative, turned, positions, rate, body, rng) -> Float[np.ndarray, "frames markers 3"]:
    """How far each marker has moved on its bone (mm): skin drawn by the joint, and swinging with the motion."""
    seconds = np.arange(len(relative)) / rate
    softness = np.array([m.softness for m in figure.markers])
    bone = np.array([m.bone for m in figure.markers])
    if not softness.any():
        return np.zeros((len(seconds), len(bone), 3))
    bent = relative - np.eye(3)
    bent[:, [b for b, one in enumerate(figure.bones) if one.parent == NO_PARENT]] = 0  # no joint draws on the root
    drawn = np.einsum("tmij,mj->tmi", bent[:, bone], _directions(body, len(bone)))
    together = smooth(rng, seconds, TREMOR_HERTZ, (len(figure.bones), 3))[:, bone]
    alone = smooth(rng, seconds, TREMOR_HERTZ, (len(bone), 3))
    shaken = _intensity(turned, positions, rate)[:, bone, None] * (together + alone)
    free = 0.5 * drawn + 0.4 * shaken
    return softness[:, None] * free / np.sqrt(1 + (free**2).sum(-1, keepdims=True))


def _directions(rng: np.random.Generator, count: int) -> Float[np.ndarray, "count 3"]:
    found = rng.normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


def _intensity(turned, positions, rate: float) -> Float[np.ndarray, "frames segments"]:
    """How hard each segment moves, 0.15 at rest and up to 1, from its turning and its acceleration."""
    if len(turned) < 3:  # too short to show any acceleration
        return np.full(turned.shape[:2], 0.15)
    step = np.swapaxes(turned[:-1], -1, -2) @ turned[1:]
    cosine = np.clip((np.trace(step, axis1=-2, axis2=-1) - 1) / 2, -1, 1)
    turning = np.arccos(cosine) * rate
    turning = np.concatenate([turning[:1], turning])
    speeding = np.gradient(np.gradient(positions, axis=0), axis=0) * rate**2
    return 0.15 + 0.85 * np.tanh(turning / SHAKING_TURN + np.linalg.norm(speeding, axis=-1) / GRAVITY / 2)
