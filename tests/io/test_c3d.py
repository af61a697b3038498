"""C3D files: what we read is what ezc3d reads, what we write ezc3d reads, and damage is an error in one line."""

import ezc3d
import numpy as np
import pytest
from integer_files import write_integers
from making import make_labelling, make_recording

from dshpm_jax import Recording, io
from dshpm_jax.io import _c3d_parameters as parameters
from dshpm_jax.io._c3d import fresh_layout
from dshpm_jax.io._c3d_format import read_layout, write_layout

C3D_FILES = [
    "pycgm-39-ghosts/Static_trial.c3d",
    "pycgm-39-ghosts/Movement_trial.c3d",
    "vicon-fullbody-52-vsk/nick_freeform_001.c3d",
    "vicon-fullbody-52-vsk/squat.c3d",
]


def by_ezc3d(path, points, labels, units="mm", rate=100.0, **point_parameters):
    """A file written by somebody else's program."""
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [rate]
    file["parameters"]["POINT"]["UNITS"]["value"] = [units]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(labels)
    for name, value in point_parameters.items():
        file.add_parameter("POINT", name, value)
    homogeneous = np.ones((4, points.shape[1], points.shape[0]))
    homogeneous[:3] = points.transpose(2, 1, 0)
    file["data"]["points"] = homogeneous
    file.write(str(path))
    return path


def error_of(path) -> str:
    with pytest.raises(io.ReadError) as caught:
        io.read(path)
    text = str(caught.value)
    assert "\n" not in text and text.startswith(f"{path}: ") and ";" in text
    return text


def test_names_that_are_none_in_this_lab(tmp_path):
    names = ("LASI", "ghost1", "Nick:ghost1", "Nick:spare", "*4")
    io.write_c3d(make_recording(labels=names), tmp_path / "walk.c3d")
    assert io.read(tmp_path / "walk.c3d").labels == names  # the names clash, so the prefixes stay
    recording = io.read(tmp_path / "walk.c3d", ("ghost*", "Nick:sp*"))
    assert recording.labels == ("LASI", "", "", "", "*4") and recording.columns == (0, 1, 2, 3, 4)
    io.write_labelled(make_labelling(recording, ["LASI"]), tmp_path / "out.c3d")
    assert io.read(tmp_path / "out.c3d").labels == ("LASI", "*1", "*2", "*3", "*4")


@pytest.mark.parametrize("rate", [1e-38, 0.009, 2e6])
def test_rates_beyond_reason(tmp_path, rate):
    io.write_c3d(make_recording(rate=rate), tmp_path / "walk.c3d")
    with pytest.raises(io.ReadError, match="frames a second; set POINT:RATE"):
        io.read(tmp_path / "walk.c3d")


@pytest.mark.parametrize("name", C3D_FILES)
def test_reads_what_ezc3d_reads(data, name):
    recording, file = io.read(data / name), ezc3d.c3d(str(data / name))
    theirs = file["data"]["points"][:3].transpose(2, 1, 0)[:, list(recording.columns)].astype(np.float64)
    residual = file["data"]["meta_points"]["residuals"][0].T[:, list(recording.columns)]
    theirs[(residual < 0) | (theirs == 0).all(-1)] = np.nan
    np.testing.assert_array_equal(recording.points, theirs)
    assert recording.rate == file["parameters"]["POINT"]["RATE"]["value"][0]


def test_model_outputs_are_no_markers(data):
    recording = io.read(data / "pycgm-39-ghosts" / "Movement_trial.c3d")
    assert recording.labelled.sum() == 39
    assert not {"PELO", "HEDA", "CentreOfMass", "LHipAngles", "LKneePower"} & set(recording.labels)
    assert (~recording.labelled).sum() == 42  # unlabelled points stay, under their placeholder


def test_subject_prefixes_are_stripped(data):
    assert io.read(data / "vicon-fullbody-52-vsk" / "squat.c3d").labels[0] == "ARIEL"


@pytest.mark.parametrize("unit, scale", [("mm", 1), ("cm", 10), ("m", 1000), ("", 1), ("Metres", 1000)])
def test_units(tmp_path, unit, scale):
    path = by_ezc3d(tmp_path / "a.c3d", np.full((2, 1, 3), 1.5), ["A"], unit)
    recording = io.read(path)
    np.testing.assert_array_equal(recording.points, 1.5 * scale)
    assert io._units.MILLIMETRES[recording.unit] == scale


def test_missing_is_nan_negative_residual_or_origin(tmp_path):
    points = np.arange(1.0, 28).reshape(3, 3, 3)
    points[1, 1] = 0
    points[2, 2] = np.nan
    file = read_layout(by_ezc3d(tmp_path / "a.c3d", points, "ABC"))
    file.points = file.points.copy()
    records = file.points.view("<f4").reshape(3, 3, 4)
    records[0, 0, 3] = -1
    write_layout(file, tmp_path / "b.c3d")
    expected = np.ones((3, 3), bool)
    expected[[0, 1, 2], [0, 1, 2]] = False
    np.testing.assert_array_equal(io.read(tmp_path / "b.c3d").present, expected)


def test_more_than_255_points(tmp_path):
    names = [f"P{k}" for k in range(600)]
    theirs = io.read(by_ezc3d(tmp_path / "a.c3d", np.ones((2, 600, 3)), names))
    assert theirs.labels == tuple(names)
    io.write_c3d(theirs, tmp_path / "b.c3d")
    point = ezc3d.c3d(str(tmp_path / "b.c3d"))["parameters"]["POINT"]
    assert point["LABELS"]["value"] + point["LABELS2"]["value"] + point["LABELS3"]["value"] == names


@pytest.mark.parametrize("writer", [by_ezc3d, None])
def test_more_than_65535_frames(tmp_path, writer):
    points = np.ones((70_001, 1, 3)) + np.arange(70_001)[:, None, None] % 1000
    if writer:
        writer(tmp_path / "a.c3d", points, ["A"])
    else:
        io.write_c3d(Recording(points, ("A",), 100.0), tmp_path / "a.c3d")
    np.testing.assert_array_equal(io.read(tmp_path / "a.c3d").points, points)


@pytest.mark.parametrize("unit", ["mm", "cm", "m"])
def test_a_recording_survives_writing(tmp_path, unit):
    recording = make_recording(unit=unit)
    io.write_c3d(recording, tmp_path / "a.c3d")
    back = io.read(tmp_path / "a.c3d")
    np.testing.assert_allclose(back.points, recording.points, rtol=1e-6)
    np.testing.assert_array_equal(back.present, recording.present)
    assert (back.labels, back.rate, back.unit) == (recording.labels, recording.rate, unit)
    theirs = ezc3d.c3d(str(tmp_path / "a.c3d"))
    assert theirs["data"]["points"].shape == (4, 4, 20)
    np.testing.assert_array_equal(theirs["data"]["meta_points"]["residuals"][0].T < 0, ~recording.present)


@pytest.mark.parametrize("processor", [parameters.INTEL, parameters.DEC, parameters.MIPS])
def test_number_formats(processor):
    values = [1.0, -1.0, 0.0, 123.456, -1e-3]
    raw = np.frombuffer(parameters.encode_floats(values, processor), np.uint8)
    np.testing.assert_array_equal(parameters.decode_floats(raw, processor), np.float32(values))


def test_dec_floats_are_those_of_a_vax():
    assert parameters.encode_floats([1.0], parameters.DEC) == bytes([0x80, 0x40, 0, 0])


def test_integer_files(tmp_path):
    """Points as 16-bit integers times POINT:SCALE, as older systems write them."""
    recording = make_recording(labels=["A", "B"])
    write_integers(recording, tmp_path / "a.c3d")
    back = io.read(tmp_path / "a.c3d")
    np.testing.assert_allclose(back.points, recording.points, atol=0.051)
    theirs = ezc3d.c3d(str(tmp_path / "a.c3d"))["data"]["points"][:3].transpose(2, 1, 0)
    np.testing.assert_allclose(back.points[back.present], theirs[back.present], rtol=1e-6)


def test_two_subjects_keep_their_prefixes(tmp_path):
    points = np.ones((2, 3, 3))
    assert io.read(by_ezc3d(tmp_path / "a.c3d", points, ["Ann:C7", "Bob:C7", "Bob:T10"])).labels[:2] == (
        "Ann:C7",
        "Bob:C7",
    )
    assert io.read(by_ezc3d(tmp_path / "b.c3d", points, ["Ann:C7", "Bob:LASI", "*3"])).labels == ("C7", "LASI", "*3")


def test_damaged_files(tmp_path):
    path = tmp_path / "a.c3d"
    io.write_c3d(make_recording(500), path)
    whole = path.read_bytes()
    for text, content in [
        ("the file is empty", b""),
        ("no C3D file", b"x"),
        ("no C3D file", b"Frame# Time\n" * 100),
        ("truncated", whole[:520]),
        ("truncated", whole[:700]),
        ("ends after", whole[: len(whole) // 2]),
        ("unknown processor", whole[:515] + b"\0" + whole[516:]),
    ]:
        path.write_bytes(content)
        assert text in error_of(path)


def test_no_byte_of_the_parameters_can_crash_the_reader(tmp_path):
    path = tmp_path / "a.c3d"
    io.write_c3d(make_recording(5), path)
    whole, rng = path.read_bytes(), np.random.default_rng(0)
    for _ in range(300):
        broken = bytearray(whole)
        for at in rng.integers(0, 1200, 4):
            broken[at] = rng.integers(256)
        path.write_bytes(broken)
        try:
            io.read(path)
        except io.ReadError as error:
            assert "\n" not in str(error)


@pytest.mark.parametrize("processor", [parameters.INTEL, parameters.DEC])
def test_bytes_that_are_no_numbers_are_missing_points(tmp_path, processor):
    """Without a warning: not-a-numbers that signal, infinities, points beyond the moon."""
    words = [b"\x01\x00\x80\x7f", b"\x00\x00\x80\x7f", b"\xff\xff\xff\x7e", b"\xff\xff\xff\xff"]
    file = fresh_layout(make_recording(labels=["A", "B"]))
    records = file.points.copy().view("S4").reshape(20, 2, 4)
    if processor == parameters.INTEL:
        for k, word in enumerate(words):
            records[k, 1, :3] = word
        file.points = np.ascontiguousarray(records).view("V16")[..., 0]
        write_layout(file, tmp_path / "a.c3d")
        assert not io.read(tmp_path / "a.c3d").present[: len(words), 1].any()
    assert np.isfinite(parameters.decode_floats(np.frombuffer(b"".join(words), np.uint8), processor)).sum() <= 4


def test_names_of_any_length_stay_a_line(tmp_path):
    by_ezc3d(tmp_path / "a.c3d", np.ones((2, 1, 3)), ["A"], units="f" * 240 + "\n" + "g" * 100)
    assert len(error_of(tmp_path / "a.c3d")) < len(str(tmp_path)) + 600


def test_files_without_what_is_needed(tmp_path):
    path = tmp_path / "a.c3d"
    seen = np.ones((3, 2, 3))
    by_ezc3d(path, np.full((3, 2, 3), np.nan), "AB")
    assert "not one point was seen" in error_of(path)
    by_ezc3d(path, seen, "AB", units="furlong")
    assert "'furlong'" in error_of(path)
    write_layout(_without_rate(), path)
    assert "0 frames a second" in error_of(path)
    io.write_c3d(Recording(np.ones((0, 2, 3)), ("A", "B"), 100.0), path)
    assert "no frames" in error_of(path)
    io.write_c3d(Recording(np.ones((3, 0, 3)), (), 100.0), path)
    assert "no points" in error_of(path)
    by_ezc3d(path, seen, ["Knee", "Hip"], ANGLES=["Knee", "Hip"])
    assert "model outputs" in error_of(path)
    assert "no such file" in error_of(tmp_path / "nowhere.c3d")
    assert "is a folder" in error_of(_made(tmp_path / "folder.c3d"))
    assert "unknown kind of file" in error_of(tmp_path / "a.xyz")


def _without_rate():
    file = fresh_layout(make_recording())
    rate = parameters.Parameter("RATE", parameters.FLOAT, (), bytes(4))
    file.groups = parameters.with_parameters(file.groups, "POINT", [rate])
    return file


def _made(folder):
    folder.mkdir()
    return folder


def test_one_frame_is_enough(tmp_path):
    assert io.read(by_ezc3d(tmp_path / "a.c3d", np.ones((1, 2, 3)), "AB")).num_frames == 1


def test_a_piece_of_a_long_capture_ends_where_its_own_count_says(tmp_path):
    """The number of its last frame is more than the header can say, and something else follows the frames."""
    recording = make_recording(30)
    file = fresh_layout(recording, 65_520)
    file.tail = bytes(range(1, 201)) * 20
    write_layout(file, tmp_path / "a.c3d")
    assert io.read(tmp_path / "a.c3d").num_frames == 30 and io.first_frame(tmp_path / "a.c3d") == 65_520
    assert ezc3d.c3d(str(tmp_path / "a.c3d"))["header"]["points"]["first_frame"] == 65_519


def test_a_marker_that_the_file_calculates_itself_is_refused(tmp_path):
    """The result would hold two columns of one name, both taken for model outputs."""
    path = by_ezc3d(tmp_path / "a.c3d", np.ones((3, 3, 3)), ["LASI", "RASI", "LHJC"], MODELED_MARKERS=["LHJC"])
    with pytest.raises(io.WriteError, match="'LHJC' is a marker of the model and a model output of the file"):
        io.write_labelled(make_labelling(io.read(path), ["LASI", "LHJC"]), tmp_path / "b.c3d")
