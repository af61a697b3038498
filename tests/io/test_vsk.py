"""Subject files of Vicon systems: what they say comes through, and damage is an error in one line."""

import numpy as np
import pytest

from dshpm_jax import io
from dshpm_jax._types import NO_PARENT
from dshpm_jax.io._vsk import read_vsk

JOINT = '<JointBall MEAN="0 0 0" COVARIANCE="0.04 0 0 0 0.01 0 0 0 4" />'
MARKERS = """
    <Marker NAME="A" SEGMENT="Hip" POSITION="A_x -A_x 3" COVARIANCE="4 0 0 0 9 0 0 0 1" />
    <Marker NAME="B" SEGMENT="Leg" POSITION="0 0 10" />
"""


def text(markers=MARKERS, joint=JOINT, extra="", head='<?xml version="1.0"?>'):
    return f"""{head}
<KinematicModel>{extra}
  <Parameters><Parameter NAME="A_x" VALUE="1.5" /><Parameter NAME="Left Leg" VALUE="400" /></Parameters>
  <Skeleton>
    <Segment NAME="Hip" POSITION="0 0 0" ORIENTATION="0 0 0"><JointFree MEAN="0 0 0 0 0 0" />
      <Segment NAME="Leg" POSITION="0 -'Left Leg' 'A_x'" ORIENTATION="0 0 1.5707963267948966">{joint}</Segment>
    </Segment>
  </Skeleton>
  <MarkerSet NAME="m"><Markers>{markers}</Markers></MarkerSet>
</KinematicModel>"""


def skeleton(tmp_path, content):
    path = tmp_path / "Nick.vsk"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_vsk(path)


def test_parameters_segments_and_covariances(tmp_path):
    found = skeleton(tmp_path, text())
    hip, leg = found.bones
    assert (hip.name, hip.parent, leg.name, leg.parent) == ("Hip", NO_PARENT, "Leg", 0)
    np.testing.assert_allclose(leg.offset, [0, -400, 1.5])
    np.testing.assert_allclose(leg.rotation @ [1, 0, 0], [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(leg.turn, [0.2, 0.1, 0.3])  # the last one is bounded
    a, b = found.markers
    np.testing.assert_allclose(a.place, [1.5, -1.5, 3])
    np.testing.assert_allclose(a.covariance, np.diag([4, 9, 1]), atol=1e-12)
    np.testing.assert_allclose(b.covariance, np.eye(3))


@pytest.mark.parametrize(
    "joint, axes",
    [
        ('<JointHinge AXIS="0 2 0" MEAN="0" COVARIANCE="1" />', [[0, 1, 0]]),
        ('<JointHardySpicer AXIS-PAIR="1 0 0 0 0 1" />', [[1, 0, 0], [0, 0, 1]]),
        ("<JointBall />", np.eye(3)),
        ("<JointDummy />", np.zeros((0, 3))),
        ("", np.zeros((0, 3))),
    ],
)
def test_joints(tmp_path, joint, axes):
    leg = skeleton(tmp_path, text(joint=joint)).bones[1]
    np.testing.assert_array_equal(leg.axes, axes)
    assert len(leg.turn) == len(axes)


def test_the_mean_of_a_joint_turns_its_segment(tmp_path):
    leg = skeleton(tmp_path, text(joint='<JointHinge AXIS="0 0 1" MEAN="-1.5707963267948966" />')).bones[1]
    np.testing.assert_allclose(leg.rotation, np.eye(3), atol=1e-12)


def test_targets_of_newer_files_and_markers_of_the_calibration_alone(tmp_path):
    markers = """<Marker NAME="A" STATUS="Required" /><Marker NAME="B" STATUS="Calibration Only" />
      </Markers><Targets>
      <TargetLocalPointToWorldPoint MARKER="A" SEGMENT="Hip" POSITION="'A_x' 0 0" WEIGHT="1" />
      <TargetLocalPointToWorldPoint MARKER="B" SEGMENT="Leg" POSITION="0 0 0" /></Targets><Markers>"""
    found = skeleton(tmp_path, text(markers)).markers
    assert [marker.name for marker in found] == ["A"]
    np.testing.assert_array_equal(found[0].place, [1.5, 0, 0])


NEWER = """<KinematicModel VERSION="3.2">
  <Parameters><Parameter NAME="k" VALUE="400"/></Parameters>
  <Skeleton><Segment NAME="thigh"><JointFree NAME="World_thigh" INVERSE-POST-POSITION="5 0 0"/>
    <Segment NAME="shank">
      <JointHinge NAME="knee" AXIS="1 0 0" MEAN="0" PRE-ORIENTATION="0 0 1.5707963267948966" PRE-POSITION="0 -'k' 0"
        INVERSE-POST-ORIENTATION="0 1.5707963267948966 0" INVERSE-POST-POSITION="0 50 0">
        <JointTemplate PRE-POSITION="9 9 9"/></JointHinge></Segment>
  </Segment></Skeleton>
  <MarkerSet><Markers><Marker NAME="A"/><Marker NAME="B"/></Markers></MarkerSet>
  <Targets><TargetLocalPointToWorldPoint MARKER="A" SEGMENT="thigh" POSITION="0 -200 40"/>
    <TargetLocalPointToWorldPoint MARKER="B" SEGMENT="shank" POSITION="0 -100 7"/></Targets></KinematicModel>"""


def test_in_the_newer_layout_joints_say_where_their_segments_stand(tmp_path):
    """A joint has a place and a turn in the parent (PRE) and in the segment (INVERSE-POST): the bone begins there."""
    found = skeleton(tmp_path, NEWER)
    thigh, shank = found.bones
    np.testing.assert_allclose(thigh.offset, 0)
    np.testing.assert_allclose(shank.offset, [-5, -400, 0])
    about_z, about_y = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    np.testing.assert_allclose(shank.rotation, about_z @ about_y.T, atol=1e-12)
    np.testing.assert_allclose(shank.axes, [about_y @ [1, 0, 0]], atol=1e-12)
    np.testing.assert_allclose([marker.place for marker in found.markers], [[-5, -200, 40], [0, -150, 7]])


def test_markers_of_the_newer_layout_are_where_both_joints_have_them(tmp_path):
    """The knee of the shank, 50 mm up in it, is that of the thigh, and its turn moves the marker in the thigh."""
    thigh, shank = skeleton(tmp_path, NEWER).bones
    marker = skeleton(tmp_path, NEWER).markers[1]
    in_thigh = shank.offset + shank.rotation @ marker.place + [5, 0, 0]
    np.testing.assert_allclose(in_thigh, [0, -400, 0] + np.array([150, -7, 0]), atol=1e-9)
    assert thigh.name == "thigh"


@pytest.mark.parametrize(
    "content, wrong",
    [
        (
            NEWER.replace('<Segment NAME="shank">', '<Segment NAME="shank" POSITION="0 0 0">'),
            "both say where it stands",
        ),
        (text().replace("""POSITION="0 -'Left Leg' 'A_x'" ORIENTATION="0 0 1.5707963267948966\"""", ""), "neither the"),
        (NEWER.replace("0 50 0", "0 50"), "has 2 numbers"),
    ],
)
def test_layouts_that_are_not_understood_are_refused(tmp_path, content, wrong):
    with pytest.raises(io.ReadError, match=wrong):
        skeleton(tmp_path, content)


@pytest.mark.parametrize(
    "content, wrong",
    [
        ("", "the file is empty"),
        ("walk", "is no XML"),
        (text()[:300], "is no XML"),
        (text(head='<?xml version="1.0" encoding="klingon"?>'), "is no XML"),
        ("<Model/>", "it holds <Model>"),
        (
            text(head='<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>', extra="&b;"),
            "DOCTYPE",
        ),
        (text(head='<!DOCTYPE a SYSTEM "file:///etc/passwd">'), "DOCTYPE"),
        (text(markers=""), "no markers"),
        (text(MARKERS + MARKERS), "two markers with the name 'A'"),
        (text(MARKERS.replace("Leg", "Arm")), "'Arm', which is no segment"),
        (text(MARKERS.replace("A_x", "A_y")), "'A_y', which is no number"),
        (text(MARKERS.replace("0 0 10", "0 0")), "has 2 numbers"),
        (text(MARKERS.replace("0 0 10", "0 0 nan")), "no finite number"),
        (text(MARKERS.replace("0 0 10", "0 0 1e300")), "no finite number"),
        (text(MARKERS.replace('POSITION="0 0 10"', "")), "is not there"),
        (text(MARKERS.replace('NAME="B"', "")), "without a name"),
        (text().replace('NAME="Leg"', 'NAME="Hip"'), "two segments with the name 'Hip'"),
    ],
)
def test_files_that_cannot_be_read(tmp_path, content, wrong):
    path = tmp_path / "Nick.vsk"
    path.write_text(content)
    with pytest.raises(io.ReadError) as caught:
        io.read_model(path)
    assert wrong in str(caught.value) and "\n" not in str(caught.value) and str(caught.value).startswith(f"{path}: ")


def test_deep_files_do_no_harm(tmp_path):
    path = tmp_path / "deep.vsk"
    deep = '<Segment NAME="{}">' * 5000
    path.write_text("<KinematicModel><Skeleton>" + deep + "</Segment>" * 5000 + "</Skeleton></KinematicModel>")
    with pytest.raises(io.ReadError, match="two segments"):
        io.read_model(path)


def test_a_real_file_agrees_with_a_recording_of_its_subject(data):
    model = io.read_model(data / "vicon-fullbody-52-vsk" / "Nick01.vsk")
    recording = io.read(data / "vicon-fullbody-52-vsk" / "nick_freeform_001.c3d")
    assert len(model.markers) == 53 and model.sources == ("Nick01.vsk",)
    assert {n for n, named in zip(recording.labels, recording.labelled, strict=True) if named} <= set(model.markers)
    pair = [recording.labels.index(n) for n in ("LFHD", "RBHD")]
    seen = np.nanmedian(np.linalg.norm(recording.points[:, pair[0]] - recording.points[:, pair[1]], axis=-1))
    i, j = (model.markers.index(n) for n in ("LFHD", "RBHD"))
    assert abs(seen - model.pair_mean[i, j]) < 5
