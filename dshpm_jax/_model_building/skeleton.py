"""Subject files of capture systems: bones, joints and where the markers sit; and the poses that these allow.

A subject file shows no motion. So we let it move: poses drawn at random within what its joints allow make a clip of the
markers, from which a model is built as from any recording. Markers of one bone then keep their distances to within
their own variance, and those across a joint vary as far as that joint turns them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from dshpm_jax._model_building.tuning import TUNING, ModelTuning
from dshpm_jax._types import NO_PARENT

MAX_TURN, MIN_TURN = 0.3, 0.1
"""rad; used by the readers of subject files: standard deviation of a joint's angle at most and at least; by hand: files
that were never told better let every joint turn as far as a hip does, and pairs across joints of a freely moving
subject spread this far."""

SEED = 0
"""The same file gives the same model."""


@dataclass(frozen=True, eq=False)
class Bone:
    """A rigid part of a skeleton, and the joint by which it hangs from its parent.

    Attributes:
        name: what the file calls it.
        parent: its place in the list of bones, before this one, or `NO_PARENT`.
        offset: the joint's place in the parent's frame (mm).
        rotation: turns the bone's frame into the parent's, in the default pose.
        axes: what the joint turns about, in the bone's frame, one after the other.
        turn: standard deviation of the angle about each axis (rad).
        slide: standard deviation of the joint's own place in each direction (mm).
    """

    name: str
    parent: int
    offset: Float[np.ndarray, "3"]
    rotation: Float[np.ndarray, "3 3"]
    axes: Float[np.ndarray, "axes 3"]
    turn: Float[np.ndarray, " axes"]
    slide: float = 0.0


@dataclass(frozen=True, eq=False)
class Attached:
    """A marker on a bone: its place in the bone's frame (mm) and how that varies (covariance, mm^2)."""

    name: str
    bone: int
    place: Float[np.ndarray, "3"]
    covariance: Float[np.ndarray, "3 3"]


@dataclass(frozen=True, eq=False)
class Skeleton:
    """What a subject file says: bones, parents before their children, and markers on them."""

    bones: tuple[Bone, ...]
    markers: tuple[Attached, ...]


def posed_clip(skeleton: Skeleton, tuning: ModelTuning = TUNING) -> Float[np.ndarray, "poses markers 3"]:
    """The markers in random poses, the first bone at rest; joint angles and markers vary normally."""
    rng, poses = np.random.default_rng(SEED), tuning.poses
    turned, origin = _bone_poses(skeleton.bones, poses, rng)
    for b in range(len(skeleton.bones)):
        line = _line_of_joints(skeleton, b)
        if line is not None:
            turned[b] = turned[b] @ _turns(line, tuning.loose_turn, poses, rng)
    clip = np.empty((poses, len(skeleton.markers), 3))
    for m, marker in enumerate(skeleton.markers):
        places = rng.multivariate_normal(marker.place, marker.covariance, poses, method="eigh")
        clip[:, m] = np.einsum("pij,pj->pi", turned[marker.bone], places) + origin[marker.bone]
    return clip


def _bone_poses(bones: Sequence[Bone], poses: int, rng: np.random.Generator) -> tuple[list, list]:
    """Rotation and origin of every bone in every pose, in the frame of the root."""
    turned: list[Float[np.ndarray, "poses 3 3"]] = []
    origin: list[Float[np.ndarray, "poses 3"]] = []
    still = np.broadcast_to(np.eye(3), (poses, 3, 3)), np.zeros((poses, 3))
    for bone in bones:
        parent_turned, parent_origin = still if bone.parent == NO_PARENT else (turned[bone.parent], origin[bone.parent])
        joint = np.broadcast_to(bone.rotation, (poses, 3, 3))
        for axis, turn in zip(bone.axes, bone.turn, strict=True):
            joint = joint @ _turns(axis, turn, poses, rng)
        turned.append(parent_turned @ joint)
        hangs = bone.offset + rng.normal(0, bone.slide, (poses, 3))
        origin.append(np.einsum("pij,pj->pi", parent_turned, hangs) + parent_origin)
    return turned, origin


def _turns(axis: np.ndarray, spread: float, poses: int, rng: np.random.Generator) -> Float[np.ndarray, "poses 3 3"]:

    from scipy.spatial.transform import Rotation  # a third of a second, which other models need not wait for

    return Rotation.from_rotvec(rng.normal(0, spread, (poses, 1)) * axis).as_matrix()


def bone_groups(skeleton: Skeleton) -> list[list[int]]:
    """The markers of each bone that has any."""
    groups = [[m for m, marker in enumerate(skeleton.markers) if marker.bone == b] for b in range(len(skeleton.bones))]
    return [group for group in groups if group]


def _line_of_joints(skeleton: Skeleton, bone: int) -> Float[np.ndarray, "3"] | None:
    """The line about which a bone may be turned without moving anything but its own markers, where nothing fixes it.

    A bone between two joints with one or two markers has its turn about the line of the joints from these alone, and
    the joints make up for it on both sides. In the files that we saw, shoulders with a marker in front and one behind
    were half a turn away from the default pose.
    """
    own = np.bincount([marker.bone for marker in skeleton.markers], minlength=len(skeleton.bones))
    below = [child.offset for c, child in enumerate(skeleton.bones) if child.parent == bone and own[c]]
    if own[bone] not in (1, 2) or len(skeleton.bones[bone].axes) < 3 or len(below) != 1:
        return None
    length = float(np.linalg.norm(below[0]))
    return below[0] / length if length > 0 else None
