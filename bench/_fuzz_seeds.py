"""Sound files of every format that is read, small, to be damaged by `fuzz.py`."""

import dataclasses
import json
from pathlib import Path

import numpy as np

from dshpm_jax import Recording, Settings, SubjectModel, write_c3d, write_model
from dshpm_jax._model_building import TUNING, posed_clip
from dshpm_jax.io._c3d import fresh_layout
from dshpm_jax.io._c3d_format import C3dFile, write_layout
from dshpm_jax.io._c3d_parameters import CHAR, DEC, FLOAT, INT, INTEL, MIPS, Group, Parameter, encode_floats, integers
from dshpm_jax.io._vsk import read_vsk
from dshpm_jax.synthesis import person

FRAMES = 12
TAKE, MODEL, LEG = "plain.c3d", "subject.json", "leg.c3d"
"""Of the sound files, a recording, its model, and a recording that `VSK` and `OSIM` are the models of."""

KNOWN = person(27, frames=2, seed=1).recording.labels
"""The markers that segments may name."""


def write_seeds(folder: Path) -> list[Path]:
    """Writes them, and gives the paths of those to be damaged."""
    whole = person(27, frames=60, seed=1).recording
    recording = Recording(whole.points[:FRAMES], whole.labels, whole.rate)
    write_c3d(recording, folder / TAKE)
    write_layout(_rich(recording), folder / "rich.c3d")
    for name, processor in (("dec", DEC), ("mips", MIPS)):
        write_layout(_other_processor(recording, processor), folder / f"{name}.c3d")
    many = Recording(np.ones((3, 300, 3)), tuple(f"P{k}" for k in range(300)), 100.0)
    write_c3d(many, folder / "many.c3d")
    model = SubjectModel.from_recordings([whole], template="body-parts")
    write_model(model, folder / MODEL)
    settings = {name: value for name, value in dataclasses.asdict(Settings()).items() if value is not None}
    groups = {s.name: {"markers": [model.markers[m] for m in s.markers]} for s in model.segments}
    texts = {
        "plain.trc": trc(recording),
        "vicon.csv": vicon(recording),
        "motive.csv": motive(recording),
        "plain.tsv": qtm(recording),
        "subject.vsk": VSK,
        "subject.osim": OSIM,
        "settings.toml": "\n".join(
            f"{name} = {json.dumps(value)}" for name, value in settings.items() if value is not None
        ),
        "segments.toml": "\n".join(f'["{name}"]\nmarkers = {entry["markers"]}' for name, entry in groups.items()),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    seeds = sorted(folder.iterdir())
    write_c3d(_leg(folder / "subject.vsk"), folder / LEG)
    return seeds


def _leg(subject_file: Path) -> Recording:
    """The markers of a subject file in one pose, drifting."""
    skeleton = read_vsk(subject_file)
    drift = np.arange(FRAMES)[:, None, None] * [2.0, 1.0, 0.5]
    pose = posed_clip(skeleton, dataclasses.replace(TUNING, poses=1))
    return Recording(pose + drift, tuple(marker.name for marker in skeleton.markers), 100.0)


def _rich(recording: Recording) -> C3dFile:
    """With analog samples, events in the header, descriptions, model outputs and bytes behind the last frame."""
    file = fresh_layout(recording)
    rng = np.random.default_rng(0)
    file.analog = rng.integers(0, 255, (FRAMES, 40), dtype=np.uint8)
    header = bytearray(file.header)
    header[4:6], header[18:20] = integers([10], INTEL), integers([10], INTEL)
    header[294:296], header[296:298] = integers([12345], INTEL), integers([2], INTEL)
    file.header, file.tail = bytes(header), rng.bytes(300)
    text = [
        Parameter("LABELS", CHAR, (4, 2), b"Fx1 Fy1 "),
        Parameter("SCALE", FLOAT, (2,), encode_floats([1, 1], INTEL)),
    ]
    file.groups[1].parameters += text
    file.groups[0].parameters.append(Parameter("ANGLES", CHAR, (4, 1), recording.labels[-1].encode()[:4].ljust(4)))
    file.groups.append(
        Group(7, "EVENT", b"what happened", parameters=[Parameter("USED", INT, (), integers([0], INTEL))])
    )
    return file


def _other_processor(recording: Recording, processor: int) -> C3dFile:
    """Points as integers, in the numbers of another processor."""
    file = fresh_layout(recording)
    order = ">" if processor == MIPS else "<"
    words = np.zeros((*recording.points.shape[:2], 4), order + "i2")
    words[..., :3] = np.nan_to_num(recording.points)
    header = bytearray(512)
    header[1] = 0x50
    header[6:10] = integers([1, FRAMES], processor)
    header[12:16], header[20:24] = encode_floats([1.0], processor), encode_floats([recording.rate], processor)
    for group in file.groups:
        group.parameters = [_as(p, processor) for p in group.parameters]
    points = np.ascontiguousarray(words).view("V8")[..., 0]
    return C3dFile(bytes(header), processor, file.groups, points, np.zeros((FRAMES, 0), np.uint8))


def _as(parameter: Parameter, processor: int) -> Parameter:
    if parameter.kind == CHAR:
        return parameter
    values = parameter.numbers(INTEL)
    whole = parameter.kind == INT
    data = integers([int(v) for v in values], processor) if whole else encode_floats(values, processor)
    return Parameter(parameter.name, parameter.kind, parameter.shape, data)


def _rows(recording: Recording, delimiter: str, lead: str, scale: float = 1.0) -> str:
    lines = []
    for t, frame in enumerate(recording.points):
        cells = ["" if np.isnan(x) else f"{x * scale:.4f}" for x in frame.ravel()]
        lines.append(delimiter.join([lead.format(frame=t + 1, time=t / recording.rate), *cells]))
    return "\n".join(lines) + "\n"


def trc(recording: Recording) -> str:
    names, count = recording.labels, len(recording.labels)
    keys = "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames"
    rate, frames = recording.rate, recording.num_frames
    values = f"{rate}\t{rate}\t{frames}\t{count}\tmm\t{rate}\t1\t{frames}"
    axes = "\t\t" + "\t".join(f"{axis}{k + 1}" for k in range(count) for axis in "XYZ")
    labels = "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t"
    head = ["PathFileType\t4\t(X/Y/Z)\twalk.trc", keys, values, labels, axes, ""]
    return "\n".join(head) + "\n" + _rows(recording, "\t", "{frame}\t{time:.4f}")


def vicon(recording: Recording) -> str:
    count = len(recording.labels)
    head = [
        "Trajectories",
        f"{recording.rate:g}",
        ",," + ",,,".join(f"Nick:{name}" for name in recording.labels) + ",,",
        "Frame,Sub Frame" + ",X,Y,Z" * count,
        "," + ",mm" * 3 * count,
    ]
    devices = "Devices\n1000\n,,Force\nFrame,Sub Frame,Fx\n,,N\n1,0,1.5\n\n"
    return devices + "\n".join(head) + "\n" + _rows(recording, ",", "{frame},0") + "\nModel Outputs\n100\n"


def motive(recording: Recording) -> str:
    count = len(recording.labels)
    head = [
        f'Format Version,1.23,Take Name,"walk, slow",Capture Frame Rate,{recording.rate},Export Frame Rate,'
        f"{recording.rate},Total Exported Frames,{recording.num_frames},Length Units,Meters",
        "",
        "," + ",Marker" * 3 * count,
        "," + "".join(f",Nick:{name}" * 3 for name in recording.labels),
        "," + "".join(f",{k}:AB" * 3 for k in range(count)),
        "," + ",Position" * 3 * count,
        "Frame,Time (Seconds)" + ",X,Y,Z" * count,
    ]
    return "\n".join(head) + "\n" + _rows(recording, ",", "{frame},{time:.6f}", 0.001)


def qtm(recording: Recording) -> str:
    names, count = recording.labels, len(recording.labels)
    head = [
        f"NO_OF_FRAMES\t{recording.num_frames}",
        "NO_OF_CAMERAS\t12",
        f"NO_OF_MARKERS\t{count}",
        f"FREQUENCY\t{recording.rate:g}",
        "DATA_INCLUDED\t3D",
        "MARKER_NAMES\t" + "\t".join(names),
        "TRAJECTORY_TYPES" + "\tMeasured" * count,
        "Frame\tTime\t" + "\t".join(f"{name} {axis}" for name in names for axis in "XYZ"),
    ]
    return "\n".join(head) + "\n" + _rows(recording, "\t", "{frame}\t{time:.5f}")


_PLACES = {
    "Hips": ("LFWT 60 70 130", "RFWT -60 70 130", "LBWT 60 70 -110", "RBWT -60 75 -110"),
    "LeftLeg": ("LTHI 60 -200 40", "LKNE 60 -400 5", "LKNI -40 -400 5"),
    "LeftFoot": ("LANK 40 -20 0", "LHEL 0 -40 -60", "LTOE 0 -50 150"),
}
_MARKERS = "".join(
    f'<Marker NAME="{name}" SEGMENT="{segment}" POSITION="{" ".join(place)}" COVARIANCE="1 0 0 0 1 0 0 0 1" />\n'
    for segment, markers in _PLACES.items()
    for name, *place in (marker.split() for marker in markers)
)
VSK = f"""<?xml version="1.0" standalone="yes"?>
<KinematicModel><Parameters><Parameter NAME="Leg" VALUE="420" /></Parameters>
<Skeleton><Segment NAME="Hips" POSITION="0 0 0" ORIENTATION="0 0 0"><JointFree MEAN="0 0 0 0 0 0" />
<Segment NAME="LeftLeg" POSITION="90 0 0" ORIENTATION="0 0 0"><JointBall MEAN="0 0 0" COVARIANCE="1 0 0 0 1 0 0 0 1" />
<Segment NAME="LeftFoot" POSITION="0 -Leg 0" ORIENTATION="0.2 0 0"><JointHinge AXIS="1 0 0" MEAN="0" /></Segment>
</Segment></Segment></Skeleton><MarkerSet NAME="m"><Markers>
{_MARKERS}</Markers></MarkerSet></KinematicModel>
"""
_STATIONS = "".join(
    f'<Marker name="{name}"><socket_parent_frame>/bodyset/{segment}</socket_parent_frame>'
    f"<location>{' '.join(str(int(x) / 1000) for x in place)}</location><fixed>false</fixed></Marker>\n"
    for segment, markers in _PLACES.items()
    for name, *place in (marker.split() for marker in markers)
)


def _joint(name: str, parent: str, child: str, place: str) -> str:
    return f"""<CustomJoint name="{name}"><socket_parent_frame>{parent}_offset</socket_parent_frame>
<socket_child_frame>{child}_offset</socket_child_frame><coordinates><Coordinate name="{name}_angle">
<default_value>0.1</default_value><range>-1 1</range><locked>false</locked></Coordinate></coordinates><frames>
<PhysicalOffsetFrame name="{parent}_offset"><socket_parent>/bodyset/{parent}</socket_parent>
<translation>{place}</translation><orientation>0 0 0</orientation></PhysicalOffsetFrame>
<PhysicalOffsetFrame name="{child}_offset"><socket_parent>/bodyset/{child}</socket_parent></PhysicalOffsetFrame>
</frames><SpatialTransform><TransformAxis name="rotation1"><coordinates>{name}_angle</coordinates><axis>0 0 1</axis>
<function><LinearFunction><coefficients>1 0</coefficients></LinearFunction></function></TransformAxis>
<TransformAxis name="translation1"><coordinates>{name}_angle</coordinates><axis>1 0 0</axis><function><SimmSpline>
<x>-1 0 1</x><y>0 0.01 0</y></SimmSpline></function></TransformAxis></SpatialTransform></CustomJoint>
"""


OSIM = f"""<?xml version="1.0" encoding="UTF-8" ?>
<OpenSimDocument Version="40000"><Model name="leg"><BodySet><objects><Body name="Hips" /><Body name="LeftLeg" />
<Body name="LeftFoot" /></objects></BodySet><JointSet><objects>{_joint("hip", "Hips", "LeftLeg", "0.09 0 0")}
{_joint("ankle", "LeftLeg", "LeftFoot", "0 -0.42 0")}</objects></JointSet>
<MarkerSet><objects>{_STATIONS}</objects></MarkerSet></Model></OpenSimDocument>
"""
