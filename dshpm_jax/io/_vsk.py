"""Subject files of Vicon systems (.vsk): parameters, a tree of segments with their joints, and markers on them."""

import re
from collections.abc import Mapping, Sequence
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

_REMEDY = "calibrate the subject and save the file again"
_TOKEN = re.compile(r"[-+]?'[^']*'|\S+")

SLIDE_MM = 50.0
"""A segment that hangs freely from another is about so far from where the file has it, in each direction."""

MAX_MARKER_SPREAD_MM = 20.0
"""A marker gives by no more, whatever its covariance says."""


def read_vsk(path: Path) -> Skeleton:
    """The skeleton of a .vsk file, of the older layout with `Marker` elements and the newer with targets.

    In the older layout a segment says where it stands in its parent. In the newer its joint does, from both sides:
    where it is in the parent (PRE-...) and where it is in the segment (INVERSE-POST-...).

    Markers that the file says are for the calibration alone are left out.
    """
    root = read_xml(path, "KinematicModel")
    numbers = _Numbers(root, path)
    bones, places, shifts = _bones(root, numbers, path)
    markers = [_attached(element, places, shifts, numbers, path) for element in _marker_elements(root)]
    if not markers:
        raise ReadError(path, "it has no markers", _REMEDY)
    names = [marker.name for marker in markers]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise ReadError(path, f"it has two markers with the name '{twice}'", "rename one of them")
    return Skeleton(tuple(bones), tuple(markers))


class _Numbers:
    """Reads attributes, whose words are numbers or names of parameters, with or without a sign and quotes."""

    def __init__(self, root: Element, path: Path):
        self.path = path
        self.parameters: Mapping[str, str] = {
            p.get("NAME", ""): p.get("VALUE", "") for group in root.iter("Parameters") for p in group.iter("Parameter")
        }

    def __call__(self, element: Element, key: str, default: str | None = None) -> Float[np.ndarray, " numbers"]:
        text = element.get(key, default)
        what = f"the {key.lower()} of '{element.get('NAME') or element.get('MARKER') or element.tag}'"
        if text is None:
            raise ReadError(self.path, f"{what} is not there", _REMEDY)
        values = np.array([self._number(word, what) for word in _TOKEN.findall(text)])
        if not np.isfinite(values).all() or (np.abs(values) > 1e9).any():
            raise ReadError(self.path, f"{what} is no finite number", _REMEDY)
        return values

    def vector(self, element: Element, key: str, default: str | None = None) -> Float[np.ndarray, "3"]:
        values = self(element, key, default)
        if len(values) != 3:
            what = f"the {key.lower()} of '{element.get('NAME') or element.get('MARKER')}'"
            raise ReadError(self.path, f"{what} has {len(values)} numbers, expected 3", _REMEDY)
        return values

    def _number(self, word: str, what: str) -> float:
        sign = -1 if word[0] == "-" else 1
        name = word.lstrip("+-").strip("'")
        try:
            return sign * float(self.parameters.get(name, name))
        except ValueError:
            raise ReadError(
                self.path, f"{what} names '{name[:40]}', which is no number and no parameter", _REMEDY
            ) from None


def _bones(
    root: Element, numbers: _Numbers, path: Path
) -> tuple[list[Bone], dict[str, int], list[Float[np.ndarray, "3"]]]:
    """Every segment, parents before their children, the place of each by name, and where its joint is in it (mm)."""
    bones: list[Bone] = []
    places: dict[str, int] = {}
    shifts: list[Float[np.ndarray, 3]] = []
    waiting = [(segment, NO_PARENT) for skeleton in root.iter("Skeleton") for segment in skeleton.findall("Segment")]
    while waiting:
        segment, parent = waiting.pop(0)
        name = segment.get("NAME", "")
        if name in places:
            raise ReadError(path, f"it has two segments with the name '{name}'", "rename one of them")
        places[name] = len(bones)
        hung = _hung(segment, parent, numbers, path)
        above = np.zeros(3) if parent == NO_PARENT else shifts[parent]
        bones.append(_bone(segment, name, parent, hung, above, numbers))
        shifts.append(hung.shift)
        waiting += [(child, places[name]) for child in segment.findall("Segment")]
    return bones, places, shifts


@dataclass(frozen=True, eq=False)
class _Hung:
    """How a segment hangs from its parent: the joint's place and turn in the parent, and its place and turn in the
    segment (mm; frames of the joint into that of either)."""

    place: Float[np.ndarray, "3"]
    turn: Rotation
    shift: Float[np.ndarray, "3"]
    inside: Rotation


def _joint(segment: Element) -> Element:
    return next((child for child in segment if child.tag.startswith("Joint")), Element("JointDummy"))


def _hung(segment: Element, parent: int, numbers: _Numbers, path: Path) -> _Hung:
    """Raises `ReadError` where neither a segment nor its joint says where it stands, or both do."""
    joint, name = _joint(segment), segment.get("NAME", "")
    newer = any(key.startswith(("PRE-", "INVERSE-POST-")) for key in joint.keys())
    older = any(key in segment.keys() for key in ("POSITION", "ORIENTATION"))
    if newer and older:
        raise ReadError(path, f"the segment '{name}' and its joint both say where it stands", _REMEDY)
    if parent != NO_PARENT and not newer and not older:
        raise ReadError(path, f"neither the segment '{name}' nor its joint says where it stands", _REMEDY)
    where, before, inside = (segment, "", "none") if older else (joint, "PRE-", "INVERSE-POST-")
    return _Hung(
        numbers.vector(where, f"{before}POSITION", "0 0 0"),
        Rotation.from_rotvec(numbers.vector(where, f"{before}ORIENTATION", "0 0 0")),
        numbers.vector(where, f"{inside}POSITION", "0 0 0"),
        Rotation.from_rotvec(numbers.vector(where, f"{inside}ORIENTATION", "0 0 0")),
    )


def _bone(
    segment: Element, name: str, parent: int, hung: _Hung, above: Float[np.ndarray, "3"], numbers: _Numbers
) -> Bone:
    """A segment as a bone whose frame has its origin in its joint; `above` is the shift of its parent."""
    joint = _joint(segment)
    axes = _axes(joint, numbers)
    mean = numbers(joint, "MEAN", "")
    turned = Rotation.from_rotvec(mean @ axes) if len(mean) == len(axes) else Rotation.identity()
    return Bone(
        name=name,
        parent=parent,
        offset=hung.place - above,
        rotation=(hung.turn * turned * hung.inside.inv()).as_matrix(),
        axes=hung.inside.apply(axes) if len(axes) else axes,
        turn=_turn(joint, len(axes), numbers),
        slide=SLIDE_MM if joint.tag == "JointFree" and parent != NO_PARENT else 0.0,
    )


def _axes(joint: Element, numbers: _Numbers) -> Float[np.ndarray, "axes 3"]:
    """What a joint turns about: nothing, the axes that it names, or all three."""
    if joint.tag == "JointDummy":
        return np.zeros((0, 3))
    named = numbers(joint, "AXIS" if joint.tag == "JointHinge" else "AXIS-PAIR", "")
    axes = named.reshape(-1, 3) if len(named) in (3, 6) else np.eye(3)
    length = np.linalg.norm(axes, axis=1, keepdims=True)
    return axes / np.where(length > 0, length, 1)


def _turn(joint: Element, axes: int, numbers: _Numbers) -> Float[np.ndarray, " axes"]:
    """Standard deviations of a joint's angles, from its covariance where it has one."""
    found = numbers(joint, "COVARIANCE", "")
    variance = np.abs(found[:: axes + 1]) if len(found) == axes**2 else np.full(axes, MAX_TURN**2)
    return np.clip(np.sqrt(variance), MIN_TURN, MAX_TURN)


def _marker_elements(root: Element) -> list[Element]:
    """The elements that place the markers: targets in the newer layout."""
    targets = list(root.iter("TargetLocalPointToWorldPoint"))
    listed = [marker for group in root.iter("Markers") for marker in group.iter("Marker")]
    aside = {marker.get("NAME") for marker in listed if marker.get("STATUS", "").lower().startswith("calib")}
    elements = targets or listed
    return [element for element in elements if (element.get("MARKER") or element.get("NAME")) not in aside]


def _attached(
    element: Element,
    places: Mapping[str, int],
    shifts: Sequence[Float[np.ndarray, "3"]],
    numbers: _Numbers,
    path: Path,
) -> Attached:
    name, segment = (element.get("MARKER") or element.get("NAME") or "").strip(), element.get("SEGMENT", "")
    if not name:
        raise ReadError(path, "it has a marker without a name", _REMEDY)
    if segment not in places:
        raise ReadError(path, f"the marker '{name}' sits on '{segment}', which is no segment", _REMEDY)
    place = numbers.vector(element, "POSITION") - shifts[places[segment]]
    return Attached(name, places[segment], place, _covariance(element, numbers))


def _covariance(element: Element, numbers: _Numbers) -> Float[np.ndarray, "3 3"]:
    """A marker's covariance (mm^2), symmetric, positive and bounded; that of a millimetre where there is none."""
    found = numbers(element, "COVARIANCE", "")
    if len(found) != 9:
        return np.eye(3)
    values, vectors = np.linalg.eigh((found.reshape(3, 3) + found.reshape(3, 3).T) / 2)
    return (vectors * np.clip(values, 0, MAX_MARKER_SPREAD_MM**2)) @ vectors.T
