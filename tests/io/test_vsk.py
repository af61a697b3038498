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
