"""Header and parameters of C3D files that disagree: the size of the file decides, or the file is refused."""

import numpy as np
import pytest

from dshpm_jax import Recording, io
from dshpm_jax.io._c3d import fresh_layout
from dshpm_jax.io._c3d_format import BLOCK, read_layout, write_layout
from dshpm_jax.io._c3d_parameters import FLOAT, INT, Group, Parameter, encode_floats, integers, with_parameters

FRAMES, CHANNELS, RATIO = 40, 2, 7


def with_samples(path, tail=b""):
    """A file of 5 points and 2 channels with 7 samples a frame, whose header and parameters agree."""
    rng = np.random.default_rng(3)
    points = (np.cumsum(rng.normal(0, 1, (FRAMES, 5, 3)), 0) + 500).astype(np.float32).astype(float)
    file = fresh_layout(Recording(points, tuple("ABCDE"), 100.0))
    file.analog = rng.normal(0, 1, (FRAMES, CHANNELS * RATIO)).astype("<f4").view(np.uint8)
    file.header = file.header[:18] + integers([RATIO], file.processor) + file.header[20:]
    rate = Parameter("RATE", FLOAT, (), encode_floats([100.0 * RATIO], file.processor))
    used = Parameter("USED", INT, (), integers([CHANNELS], file.processor))
    file.groups = with_parameters(file.groups, "ANALOG", [used, rate])
    file.tail = tail
    write_layout(file, path)
    return points


def set_header(path, word, value):
    raw = bytearray(path.read_bytes())
    raw[2 * word : 2 * word + 2] = int(value).to_bytes(2, "little")
    path.write_bytes(raw)


def set_parameter(path, group, name, value):
    """Writes a number over that of a parameter, in place."""
    raw = path.read_bytes()
    file = read_layout(path)
    found = file.find(group, name)
    assert found is not None
    start = raw.index(name.encode() + b"", raw.index(group.encode()))
    at = start + len(name) + 4 + len(found.shape)
    data = encode_floats([value], file.processor) if found.kind == FLOAT else integers([value], file.processor)
    assert raw[at : at + len(data)] == found.data
    path.write_bytes(raw[:at] + data + raw[at + len(data) :])


HEADER = {"points": (1, 4), "channels for samples": (2, CHANNELS), "samples": (2, 3), "last": (4, 30), "start": (8, 9)}
PARAMETERS = {
    "points": ("POINT", "USED", 7),
    "frames": ("POINT", "FRAMES", 39),
    "no frames": ("POINT", "FRAMES", 0),
    "channels": ("ANALOG", "USED", 3),
    "no channels": ("ANALOG", "USED", 0),
    "rate": ("ANALOG", "RATE", 300.0),
    "start": ("POINT", "DATA_START", 2),
}


@pytest.mark.parametrize("wrong", HEADER)
def test_a_wrong_header_is_found_out_by_the_size(tmp_path, wrong):
    points = with_samples(tmp_path / "a.c3d")
    set_header(tmp_path / "a.c3d", *HEADER[wrong])
    np.testing.assert_array_equal(io.read(tmp_path / "a.c3d").points, points)


@pytest.mark.parametrize("wrong", PARAMETERS)
def test_wrong_parameters_are_found_out_by_the_size(tmp_path, wrong):
    points = with_samples(tmp_path / "a.c3d")
    set_parameter(tmp_path / "a.c3d", *PARAMETERS[wrong])
    np.testing.assert_array_equal(io.read(tmp_path / "a.c3d").points, points)


def test_what_follows_the_frames_changes_nothing(tmp_path):
    points = with_samples(tmp_path / "a.c3d", tail=bytes(range(1, 251)) * 9)
    set_header(tmp_path / "a.c3d", *HEADER["channels for samples"])
    np.testing.assert_array_equal(io.read(tmp_path / "a.c3d").points, points)


def test_where_neither_fits_both_numbers_are_said(tmp_path):
    with_samples(tmp_path / "a.c3d")
    set_header(tmp_path / "a.c3d", *HEADER["channels for samples"])
    cut = (tmp_path / "a.c3d").read_bytes()[: -2 * BLOCK]
    (tmp_path / "a.c3d").write_bytes(cut)
    with pytest.raises(io.ReadError, match=f"analog samples a frame: 2 or 14\\), and its size of {len(cut)} bytes"):
        io.read(tmp_path / "a.c3d")


def test_channels_in_the_place_of_samples_a_frame(tmp_path):
    """As one system writes it: read for 20 years as coordinates of another frame."""
    x = np.arange(100.0, 200, 10)
    points = np.stack([x, x + 5, x + 90], axis=-1)[:, None]
    file = fresh_layout(Recording(points, ("A",), 100.0))
    file.analog = np.full((10, CHANNELS * RATIO), 0.5, "<f4").view(np.uint8)
    new = [Parameter("USED", INT, (), integers([CHANNELS], 84)), Parameter("RATE", FLOAT, (), encode_floats([700], 84))]
    file.groups = with_parameters(file.groups, "ANALOG", new)
    write_layout(file, tmp_path / "a.c3d")
    set_header(tmp_path / "a.c3d", 2, CHANNELS)
    recording = io.read(tmp_path / "a.c3d")
    np.testing.assert_array_equal(recording.points[:, 0, 0], x)
    assert recording.num_frames == 10


def test_numbers_of_two_or_four_bytes(tmp_path):
    points = with_samples(tmp_path / "a.c3d")
    raw = bytearray((tmp_path / "a.c3d").read_bytes())
    raw[12:16] = encode_floats([0.1], 84)  # integers, by the header alone
    (tmp_path / "a.c3d").write_bytes(raw)
    np.testing.assert_array_equal(io.read(tmp_path / "a.c3d").points, points)


def test_rotations_end_the_frames(tmp_path):
    """They stand behind the last frame, and their group says where."""
    points = with_samples(tmp_path / "a.c3d", tail=bytes(range(250)) * 20)
    file = read_layout(tmp_path / "a.c3d")
    start = Parameter("DATA_START", INT, (), integers([1], file.processor))
    file.groups = [*file.groups, Group(9, "ROTATION", parameters=[start])]
    write_layout(file, tmp_path / "b.c3d")
    set_header(tmp_path / "b.c3d", *HEADER["channels for samples"])
    found = read_layout(tmp_path / "b.c3d")
    assert found.tail.startswith(bytes(range(250)))
    np.testing.assert_array_equal(io.read(tmp_path / "b.c3d").points, points)


def test_data_within_the_parameters_are_none(tmp_path):
    with_samples(tmp_path / "a.c3d")
    set_header(tmp_path / "a.c3d", 8, 0)
    set_parameter(tmp_path / "a.c3d", "POINT", "DATA_START", 2)
    with pytest.raises(io.ReadError, match="where behind its parameters its data start"):
        io.read(tmp_path / "a.c3d")


def test_what_leaves_something_behind_the_last_frame_fits_no_size(tmp_path):
    """Header and parameter are both wrong: one number may fit by chance, but then data stand where none should."""
    with_samples(tmp_path / "a.c3d")
    set_header(tmp_path / "a.c3d", 2, 13)
    set_parameter(tmp_path / "a.c3d", "ANALOG", "USED", 1)
    with pytest.raises(io.ReadError, match="its size of .* fits neither"):
        io.read(tmp_path / "a.c3d")
