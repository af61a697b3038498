"""OpenSim models: both layouts say the same, and the default pose is where OpenSim puts it."""

import numpy as np
import pytest

from dshpm_jax import io
from dshpm_jax._model_building.skeleton import Bone, Skeleton
from dshpm_jax.io._osim import read_osim

COORDINATE = """<Coordinate name="flexion"><motion_type>rotational</motion_type>
  <default_value>0.5</default_value><range>-0.6 0.6</range><locked>false</locked></Coordinate>"""
TRANSFORM = """<SpatialTransform>
  <TransformAxis name="rotation1"><coordinates>flexion</coordinates><axis>0 0 1</axis>
    <function><LinearFunction><coefficients>1 0</coefficients></LinearFunction></function></TransformAxis>
  <TransformAxis name="rotation2"><coordinates></coordinates><axis>0 1 0</axis>
    <function><Constant><value>0</value></Constant></function></TransformAxis>
  <TransformAxis name="translation1"><coordinates>flexion</coordinates><axis>1 0 0</axis>
    <function><SimmSpline><x>-1 0 1</x><y>0.1 0 0.02</y></SimmSpline></function></TransformAxis>
</SpatialTransform>"""
OLD = f"""<?xml version="1.0" encoding="UTF-8"?>
<OpenSimDocument Version="30000"><Model name="leg"><BodySet><objects>
  <Body name="ground"><Joint /></Body>
  <Body name="femur"><Joint><CustomJoint name="hip"><parent_body>ground</parent_body>
    <location_in_parent>0 1 0</location_in_parent><location>0.1 0 0</location></CustomJoint></Joint></Body>
  <Body name="tibia"><Joint><CustomJoint name="knee"><parent_body>femur</parent_body>
    <location_in_parent>0.1 -0.4 0</location_in_parent><orientation_in_parent>0 0 0.3</orientation_in_parent>
    <location>0 0.05 0</location><orientation>0 0 0.1</orientation>
    <CoordinateSet><objects>{COORDINATE}</objects></CoordinateSet>{TRANSFORM}</CustomJoint></Joint></Body>
</objects></BodySet><MarkerSet><objects>
  <Marker name="THI"><body>femur</body><location>0.2 -0.1 0</location><fixed>false</fixed></Marker>
  <Marker name="ANK"><body>tibia</body><location>0.01 -0.35 0.02</location><fixed>true</fixed></Marker>
</objects></MarkerSet></Model></OpenSimDocument>"""
NEW = f"""<?xml version="1.0" encoding="UTF-8"?>
<OpenSimDocument Version="40000"><Model name="leg"><BodySet><objects>
  <Body name="femur" /><Body name="tibia" /></objects></BodySet>
<JointSet><objects>
  <CustomJoint name="knee"><socket_parent_frame>femur_offset</socket_parent_frame>
    <socket_child_frame>tibia_offset</socket_child_frame><coordinates>{COORDINATE}</coordinates><frames>
    <PhysicalOffsetFrame name="femur_offset"><socket_parent>/bodyset/femur</socket_parent>
      <translation>0.1 -0.4 0</translation><orientation>0 0 0.3</orientation></PhysicalOffsetFrame>
    <PhysicalOffsetFrame name="tibia_offset"><socket_parent>/bodyset/tibia</socket_parent>
      <translation>0 0.05 0</translation><orientation>0 0 0.1</orientation></PhysicalOffsetFrame>
    </frames>{TRANSFORM}</CustomJoint>
  <CustomJoint name="hip"><socket_parent_frame>ground_offset</socket_parent_frame>
    <socket_child_frame>femur_offset</socket_child_frame><frames>
    <PhysicalOffsetFrame name="ground_offset"><socket_parent>/ground</socket_parent>
      <translation>0 1 0</translation></PhysicalOffsetFrame>
    <PhysicalOffsetFrame name="femur_offset"><socket_parent>/bodyset/femur</socket_parent>
      <translation>0.1 0 0</translation></PhysicalOffsetFrame></frames></CustomJoint>
</objects></JointSet><MarkerSet><objects>
  <Marker name="THI"><socket_parent_frame>/bodyset/femur</socket_parent_frame><location>0.2 -0.1 0</location>
    <fixed>false</fixed></Marker>
  <Marker name="ANK"><socket_parent_frame>/bodyset/tibia</socket_parent_frame><location>0.01 -0.35 0.02</location>
    <fixed>true</fixed></Marker>
</objects></MarkerSet></Model></OpenSimDocument>"""


def skeleton(tmp_path, content: str) -> Skeleton:
    (tmp_path / "leg.osim").write_text(content)
    return read_osim(tmp_path / "leg.osim")


def places(found: Skeleton) -> np.ndarray:
    """The markers in the default pose, in the frame of the root (mm)."""
    poses: list[tuple[np.ndarray, np.ndarray]] = []
    for bone in found.bones:
        turned, origin = (np.eye(3), np.zeros(3)) if bone.parent < 0 else poses[bone.parent]
        poses.append((turned @ bone.rotation, origin + turned @ bone.offset))
    return np.array([poses[m.bone][0] @ m.place + poses[m.bone][1] for m in found.markers])


def turn(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


@pytest.mark.parametrize("content", [OLD, NEW])
def test_the_default_pose(tmp_path, content):
    found = skeleton(tmp_path, content)
    thigh, ankle = places(found)
    joint = np.array([100, -400, 0]) + turn(0.3) @ [10, 0, 0]  # half way between the points of the spline
    expected = joint + turn(0.3 + 0.5) @ turn(0.1).T @ (np.array([10, -350, 20]) - [0, 50, 0])
    np.testing.assert_allclose(ankle - thigh, expected - [200, -100, 0], atol=1e-9)


@pytest.mark.parametrize("content", [OLD, NEW])
def test_joints_turn_by_their_range(tmp_path, content):
    tibia: Bone = next(bone for bone in skeleton(tmp_path, content).bones if bone.name == "tibia")
    np.testing.assert_allclose(tibia.axes[0], [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(tibia.turn, [0.2, 0, 0])


def test_a_locked_joint_does_not_turn(tmp_path):
    locked = NEW.replace("<locked>false", "<locked>true")
    tibia = next(bone for bone in skeleton(tmp_path, locked).bones if bone.name == "tibia")
    assert not tibia.turn.any()


def test_axes_are_those_of_the_frame_that_has_turned(tmp_path):
    """Turning the second of three axes by a little moves a point as OpenSim's order of rotations does."""
    from scipy.spatial.transform import Rotation

    from dshpm_jax.io._osim import _in_own_frame

    axes, angles = [np.eye(3)[k] for k in (2, 0, 1)], np.array([0.4, -0.7, 1.1])

    def product(values):
        whole = np.eye(3)
        for axis, value in zip(axes, values, strict=True):
            whole = whole @ Rotation.from_rotvec(axis * value).as_matrix()
        return whole

    rotation, own = _in_own_frame(list(zip(axes, angles, strict=True)))
    np.testing.assert_allclose(rotation, product(angles), atol=1e-12)
    more = np.array([0.2, -0.1, 0.3])
    after = rotation
    for axis, value in zip(own, more, strict=True):
        after = after @ Rotation.from_rotvec(axis * value).as_matrix()
    np.testing.assert_allclose(after, product(angles + more), atol=1e-12)


@pytest.mark.parametrize(
    "content, wrong",
    [
        ("<OpenSimDocument/>", "no markers"),
        (NEW.replace("/bodyset/tibia</socket_parent_frame>", "/bodyset/foot</socket_parent_frame>"), "is no body"),
        (NEW.replace('"ANK"', '"THI"'), "two markers with the name 'THI'"),
        (NEW.replace('"ANK"', '""'), "without a name"),
        (NEW.replace("0.01 -0.35 0.02", "0.01 -0.35"), "has 2 numbers"),
        (NEW.replace("0.01 -0.35 0.02", "here"), "no row of numbers"),
        (NEW.replace("/ground</socket_parent>", "/bodyset/tibia</socket_parent>"), "round in a circle"),
        (NEW.replace("<x>-1 0 1</x>", "<x>-1 1 0</x>"), "unsorted"),
        (OLD.replace('Body name="ground"', 'Body name="tibia"'), ""),
    ],
)
def test_files_that_cannot_be_read(tmp_path, content, wrong):
    path = tmp_path / "leg.osim"
    path.write_text(content)
    try:
        io.read_model(path)
    except io.ReadError as error:
        assert wrong in str(error) and "\n" not in str(error) and str(error).startswith(f"{path}: ")
    else:
        assert not wrong


MARKER_SET = """<?xml version="1.0" encoding="UTF-8"?>
<OpenSimDocument Version="30000"><MarkerSet name="mine"><objects>
  <Marker name="SHI"><body>tibia</body><location>0.03 -0.2 0</location><fixed>false</fixed></Marker>
  <Marker name="PAT"><socket_parent_frame>/bodyset/femur</socket_parent_frame><location>0 -0.4 0.05</location></Marker>
</objects></MarkerSet></OpenSimDocument>"""


@pytest.mark.parametrize("content", [OLD, NEW, OLD.replace("<Marker ", "<!-- ").replace("</Marker>", " -->")])
def test_a_marker_set_beside_a_model(tmp_path, content):
    """Its markers are the only ones; a model alone may have none."""
    (tmp_path / "leg.osim").write_text(content)
    (tmp_path / "set.xml").write_text(MARKER_SET)
    found = read_osim(tmp_path / "leg.osim", tmp_path / "set.xml")
    assert [(marker.name, found.bones[marker.bone].name) for marker in found.markers] == [
        ("SHI", "tibia"),
        ("PAT", "femur"),
    ]
    own = {bone.name: bone for bone in skeleton(tmp_path, OLD).bones}
    for bone in found.bones[1:]:
        np.testing.assert_allclose(bone.offset, own[bone.name].offset, atol=1e-9)


def test_marker_sets_that_are_none(tmp_path):
    (tmp_path / "leg.osim").write_text(OLD)
    (tmp_path / "set.xml").write_text(MARKER_SET.replace("tibia", "tail"))
    with pytest.raises(io.ReadError, match="set.xml: the marker 'SHI' sits on 'tail', which is no body"):
        read_osim(tmp_path / "leg.osim", tmp_path / "set.xml")
    (tmp_path / "set.xml").write_text("<MarkerSet />")
    with pytest.raises(io.ReadError, match="set.xml: it holds <MarkerSet>"):
        read_osim(tmp_path / "leg.osim", tmp_path / "set.xml")
    for name in ("Nick.vsk", "model.json"):
        with pytest.raises(io.ReadError, match="goes with an .osim file alone"):
            io.read_model(tmp_path / name, tmp_path / "set.xml")


@pytest.mark.parametrize("head", ['<?xml version="1.0" encoding="UTF-8"?>', "<?xml version='1.0'?>", ""])
def test_a_file_that_is_no_utf8_although_it_says_so(tmp_path, head):
    """A name typed on a machine with another alphabet is no reason to refuse the model."""
    content = OLD.replace('<?xml version="1.0" encoding="UTF-8"?>', head, 1).lstrip().replace("THI", "CÔT\u00c9")
    (tmp_path / "leg.osim").write_bytes(content.encode("latin-1"))
    assert read_osim(tmp_path / "leg.osim").markers[0].name == "CÔT\u00c9"
    (tmp_path / "leg.osim").write_bytes(content.encode())
    assert read_osim(tmp_path / "leg.osim").markers[0].name == "CÔT\u00c9"
