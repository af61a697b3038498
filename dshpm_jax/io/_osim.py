"""Musculoskeletal models of OpenSim (.osim): bodies, the joints between them, and the marker set."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from dshpm_jax._model_building.skeleton import MAX_TURN, MIN_TURN, Attached, Bone, Skeleton
from dshpm_jax._types import NO_PARENT
from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._xml import read_xml

_REMEDY = "export the model again, with its marker set"
MILLIMETRES = 1000.0  # OpenSim counts in metres
ADJUSTED_MM, FIXED_MM = 5.0, 10.0
"""Standard deviation of a marker that was moved to where the subject wears it, and of one that was not."""

FULL_RANGE = 6.0
"""A joint's range has so many standard deviations of its angle."""

_FRAME_X, _FRAME_Y, _FRAME_Z = np.eye(3)
_AXES = {
    "WeldJoint": [],
    "PinJoint": [_FRAME_Z],
    "SliderJoint": [],
    "PlanarJoint": [_FRAME_Z],
    "UniversalJoint": [_FRAME_X, _FRAME_Y],
}
"""Axes of the joints that do not name them; all others turn about all three."""


@dataclass(frozen=True, eq=False)
class _Frame:
    """A frame on a body: its rotation and its origin (mm) in the frame of that body."""

    body: str
    rotation: Float[np.ndarray, "3 3"]
    origin: Float[np.ndarray, "3"]


@dataclass(frozen=True, eq=False)
class _Joint:
    """Where a joint sits on the parent and on the child, and how it turns from its default."""

    parent: _Frame
    child: _Frame
    rotation: Float[np.ndarray, "3 3"]
    origin: Float[np.ndarray, "3"]
    axes: Float[np.ndarray, "axes 3"]
    turn: Float[np.ndarray, " axes"]


def read_osim(path: Path, marker_set: Path | None = None) -> Skeleton:
    """The skeleton of an .osim file, of version 3 (joints inside bodies) or 4 (a set of joints between frames).

    Arguments:
        marker_set: an .xml file of markers, which then are the only ones.
    """
    root = read_xml(path, "OpenSimDocument")
    read = _Reader(path)
    joints = _by_child(read.joints(root), path)
    bodies = dict.fromkeys(body.get("name", "") for body in root.iter("Body"))
    order = _parents_first(bodies, joints, path)
    places = {body: k for k, body in enumerate(order)}
    bones = tuple(_bone(body, joints, places) for body in order)
    if marker_set is not None:
        path, root = marker_set, read_xml(marker_set, "OpenSimDocument")
        read = _Reader(path)
    markers = tuple(read.marker(element, joints, places) for element in root.iter("Marker"))
    if not markers:
        remedy = "give its marker set with --markers" if marker_set is None else "export the marker set again"
        raise ReadError(path, "it has no markers", remedy)
    names = [marker.name for marker in markers]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise ReadError(path, f"it has two markers with the name '{twice}'", "rename one of them")
    return Skeleton(bones, markers)


class _Reader:
    """Reads the elements of one file; what is wrong names the file and the element."""

    def __init__(self, path: Path):
        self.path = path

    def numbers(self, element: Element | None, key: str, default: str) -> Float[np.ndarray, " numbers"]:
        text = default if element is None else element.findtext(key) or default
        try:
            values = np.array([float(word) for word in text.split()])
        except ValueError:
            values = np.array([np.nan])
        if not np.isfinite(values).all() or (np.abs(values) > 1e6).any():
            name = "" if element is None else element.get("name") or element.tag
            raise ReadError(self.path, f"the {key} of '{name}' is no row of numbers", _REMEDY)
        return values

    def vector(self, element: Element | None, key: str) -> Float[np.ndarray, "3"]:
        values = self.numbers(element, key, "0 0 0")
        if len(values) != 3:
            name = "" if element is None else element.get("name") or element.tag
            raise ReadError(self.path, f"the {key} of '{name}' has {len(values)} numbers, expected 3", _REMEDY)
        return values

    def frame(self, element: Element | None, body: str, where: str, turned: str) -> _Frame:
        return _Frame(body, _euler(self.vector(element, turned)), self.vector(element, where) * MILLIMETRES)

    def joints(self, root: Element) -> Iterator[_Joint]:
        """Every joint of the file: of version 3 inside the child's `Body`, of version 4 in the `JointSet`."""
        for body in root.iter("Body"):
            for joint in body.findall("Joint/*"):
                if parent := (joint.findtext("parent_body") or "").strip():
                    on_parent = self.frame(joint, parent, "location_in_parent", "orientation_in_parent")
                    on_child = self.frame(joint, body.get("name", ""), "location", "orientation")
                    yield self._joint(joint, on_parent, on_child)
        for joint in root.findall(".//JointSet/objects/*"):
            frames = {frame.get("name", ""): frame for frame in joint.iter("PhysicalOffsetFrame")}
            ends = [self._end(joint, f"socket_{end}_frame", frames) for end in ("parent", "child")]
            yield self._joint(joint, ends[0], ends[1])

    def _end(self, joint: Element, socket: str, frames: Mapping[str, Element]) -> _Frame:
        name = _socket(joint, socket)
        offset = frames.get(name)
        body = name if offset is None else _socket(offset, "socket_parent")
        return self.frame(offset, body, "translation", "orientation")

    def _joint(self, joint: Element, parent: _Frame, child: _Frame) -> _Joint:
        coordinates = {c.get("name", ""): c for c in joint.iter("Coordinate")}
        transform = joint.find("SpatialTransform")
        if transform is None:
            return self._plain_joint(joint, parent, child, list(coordinates.values()))
        moves = {axis.get("name", ""): axis for axis in transform.findall("TransformAxis")}
        turns = [self._move(moves.get(f"rotation{k}"), coordinates) for k in (1, 2, 3)]
        slides = [self._move(moves.get(f"translation{k}"), coordinates) for k in (1, 2, 3)]
        rotation, axes = _in_own_frame([(axis, value) for axis, value, _ in turns])
        origin = sum((axis * value for axis, value, _ in slides), np.zeros(3)) * MILLIMETRES
        return _Joint(parent, child, rotation, origin, axes, np.array([turn for *_, turn in turns]))

    def _plain_joint(self, joint: Element, parent: _Frame, child: _Frame, coordinates: list[Element]) -> _Joint:
        """A joint whose kind says what it turns about; its rotations come before its translations."""
        axes = _AXES.get(joint.tag, list(np.eye(3)))
        known = [coordinates[k] if k < len(coordinates) else None for k in range(len(axes))]
        values = [self._value(coordinate) for coordinate in known]
        rotation, own = _in_own_frame(list(zip(axes, values, strict=True)))
        return _Joint(parent, child, rotation, np.zeros(3), own, np.array([self._turn(c) for c in known]))

    def _move(self, axis: Element | None, coordinates: Mapping[str, Element]) -> tuple[np.ndarray, float, float]:
        """What a transform's axis is, its default value (rad or m), and the spread of that (rad)."""
        direction = self.vector(axis, "axis")
        length = np.linalg.norm(direction)
        direction = direction / length if length > 0 else direction
        names = (axis.findtext("coordinates") or "").split() if axis is not None else []
        coordinate = coordinates.get(names[0]) if names else None
        value, slope = self._function(axis, self._value(coordinate))
        return direction, value, abs(slope) * self._turn(coordinate) if coordinate is not None else 0.0

    def _function(self, axis: Element | None, at: float) -> tuple[float, float]:
        """Value and slope of the function of an axis; curves that couple a joint's motions count as fixed."""
        if axis is None:
            return 0.0, 0.0
        for kind in axis.iter():
            if kind.tag == "LinearFunction":
                slope, shift = (*self.numbers(kind, "coefficients", "1 0"), 0.0, 0.0)[:2]
                return float(slope * at + shift), float(slope)
            if kind.tag == "Constant":
                return float(self.numbers(kind, "value", "0")[0]), 0.0
            if kind.find("x") is not None and kind.find("y") is not None:
                x, y = self.numbers(kind, "x", "0"), self.numbers(kind, "y", "0")
                if len(x) != len(y) or (np.diff(x) < 0).any():
                    raise ReadError(self.path, f"the curve of '{axis.get('name')}' has unsorted points", _REMEDY)
                return float(np.interp(at, x, y)), 0.0
        return at, 1.0

    def _value(self, coordinate: Element | None) -> float:
        return float(self.numbers(coordinate, "default_value", "0")[0])

    def _turn(self, coordinate: Element | None) -> float:
        """Standard deviation of a coordinate's angle (rad), by its range; none where it is locked."""
        if coordinate is None:
            return MAX_TURN
        if (coordinate.findtext("locked") or "").strip().lower() == "true":
            return 0.0
        span = np.ptp(self.numbers(coordinate, "range", f"0 {math.pi}"))
        return float(np.clip(span / FULL_RANGE, MIN_TURN, MAX_TURN))

    def marker(self, element: Element, joints: Mapping[str, _Joint], places: Mapping[str, int]) -> Attached:
        name = element.get("name", "").strip()
        if not name:
            raise ReadError(self.path, "it has a marker without a name", _REMEDY)
        body = (element.findtext("body") or "").strip() or _socket(element, "socket_parent_frame")
        if body not in places:
            raise ReadError(self.path, f"the marker '{name}' sits on '{body}', which is no body", _REMEDY)
        place = self.vector(element, "location") * MILLIMETRES
        if body in joints:  # bones count from where their joint is
            frame = joints[body].child
            place = frame.rotation.T @ (place - frame.origin)
        fixed = (element.findtext("fixed") or "").strip().lower() == "true"
        return Attached(name, places[body], place, np.eye(3) * (FIXED_MM if fixed else ADJUSTED_MM) ** 2)


def _socket(element: Element, name: str) -> str:
    """What a socket is connected to, without the path to it; early files of version 4 spell its tag out longer."""
    text = element.findtext(name) or element.findtext(f"{name}_connectee_name") or ""
    return text.strip().rsplit("/", 1)[-1]


def _euler(angles: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    return Rotation.from_euler("XYZ", angles).as_matrix()


def _in_own_frame(turns: list[tuple[np.ndarray, float]]) -> tuple[np.ndarray, Float[np.ndarray, "axes 3"]]:
    """The rotation of turns made one after the other, and their axes as the frame that has turned sees them."""
    rotation, axes = np.eye(3), []
    for axis, angle in reversed(turns):
        axes.append(rotation.T @ axis)
        rotation = Rotation.from_rotvec(axis * angle).as_matrix() @ rotation
    return rotation, np.array(axes[::-1]).reshape(-1, 3)


def _by_child(joints: Iterator[_Joint], path: Path) -> dict[str, _Joint]:
    found: dict[str, _Joint] = {}
    for joint in joints:
        if joint.child.body in found:
            raise ReadError(path, f"the body '{joint.child.body}' hangs from two joints", "take one of them out")
        found[joint.child.body] = joint
    return found


def _parents_first(bodies: Mapping[str, None], joints: Mapping[str, _Joint], path: Path) -> list[str]:
    """The bodies, parents before their children; the ground is none."""
    below: dict[str, list[str]] = {}
    for body in bodies:
        parent = joints[body].parent.body if body in joints else ""
        below.setdefault(parent if parent in bodies else "", []).append(body)
    order, waiting = [], below.pop("", [])
    while waiting:
        body = waiting.pop(0)
        order.append(body)
        waiting += below.pop(body, [])
    if len(order) < len(bodies):
        lost = next(body for body in bodies if body not in order)
        raise ReadError(path, f"the joints of '{lost}' go round in a circle", "mend its joints")
    return order


def _bone(body: str, joints: Mapping[str, _Joint], places: Mapping[str, int]) -> Bone:
    """A body as a bone whose frame is that of its joint."""
    joint = joints.get(body)
    if joint is None or joint.parent.body not in places:
        return Bone(body, NO_PARENT, np.zeros(3), np.eye(3), np.zeros((0, 3)), np.zeros(0))
    above = joints.get(joint.parent.body)
    frame = _Frame("", np.eye(3), np.zeros(3)) if above is None else above.child
    turned = frame.rotation.T @ joint.parent.rotation
    offset = frame.rotation.T @ (joint.parent.origin - frame.origin) + turned @ joint.origin
    return Bone(body, places[joint.parent.body], offset, turned @ joint.rotation, joint.axes, joint.turn)
