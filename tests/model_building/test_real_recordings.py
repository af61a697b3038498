"""Segments found on real recordings, as an anatomist would draw them."""

import pytest

from dshpm_jax import SubjectModel
from dshpm_jax.io import read

LIMBS = {f"{side} {part}" for side in ("left", "right") for part in ("thigh", "shank", "foot", "upper arm", "forearm")}


@pytest.mark.parametrize(
    ("file", "frames"),
    [
        ("mocaptoolbox-28/dance2.trc", 300),
        ("hamner04-42-run/run200_markers.trc", 237),
        ("opencap-s4-47/DJ1.trc", 269),
        ("sprinter-51/run0350cms.trc", 836),
        ("vicon-fullbody-52-vsk/squat.c3d", 800),
    ],
)
def test_every_limb_is_a_segment_of_its_own_side(data, file, frames):
    model = SubjectModel.from_recordings([read(data / file).frames(0, frames)])
    names = {segment.name for segment in model.segments}
    assert names >= LIMBS | {"trunk", "pelvis"}
    assert {m for segment in model.segments for m in segment.markers} == set(range(model.num_markers))
    assert len(model.segments) <= 18
    for segment in model.segments:
        parent = model.segments[segment.parent].name if segment.parent >= 0 else ""
        sides = {word for word in (*segment.name.split(), *parent.split()) if word in ("left", "right")}
        assert len(sides) < 2, f"{segment.name} hangs from {parent}"
