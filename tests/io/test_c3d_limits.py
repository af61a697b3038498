"""Every 16-bit number of a C3D file at its limit, and one beyond: written and read back, or refused in one line."""

import numpy as np
import pytest
from making import make_labelling

from dshpm_jax import Recording, io
from dshpm_jax.io._c3d import fresh_layout
from dshpm_jax.io._c3d_format import read_layout, write_layout
from dshpm_jax.io._c3d_parameters import CHAR, FLOAT, INT, Group, Parameter, integers, pack_parameters, with_parameters

LIMIT = 0xFFFF


def recording(frames=2, points=1, label=""):
    places = np.arange(frames * points * 3, dtype=float).reshape(frames, points, 3) % 1000 + 1
    return Recording(places, (label,) * points, 100.0)


@pytest.mark.parametrize("frames", [LIMIT - 1, LIMIT, LIMIT + 1])
def test_frames(tmp_path, frames):
    given = recording(frames)
    io.write_c3d(given, tmp_path / "a.c3d")
    np.testing.assert_array_equal(io.read(tmp_path / "a.c3d").points, given.points)


@pytest.mark.parametrize("first", [LIMIT - 2, LIMIT - 1, LIMIT, LIMIT + 1, (1 << 31) - 1])
def test_number_of_the_first_frame(tmp_path, first):
    write_layout(fresh_layout(recording(3), first), tmp_path / "a.c3d")
    assert io.first_frame(tmp_path / "a.c3d") == first and io.read(tmp_path / "a.c3d").num_frames == 3


def test_points(tmp_path):
    given = recording(points=LIMIT)
    io.write_c3d(given, tmp_path / "a.c3d")
    np.testing.assert_array_equal(io.read(tmp_path / "a.c3d").points, given.points)
    with pytest.raises(io.WriteError, match="65536 points are more than a C3D file holds"):
        io.write_c3d(recording(points=LIMIT + 1), tmp_path / "b.c3d")


@pytest.mark.parametrize("samples", [LIMIT, LIMIT + 1])
def test_analog_samples_of_a_frame(tmp_path, samples):
    """The header cannot count one more; then the parameters and the size of the file say it."""
    file = fresh_layout(recording(4))
    file.analog = np.ones((4, samples), "<f4").view(np.uint8)
    used = [Parameter("USED", INT, (), integers([samples // 257], 84)), Parameter("RATE", FLOAT, (), rate(257 * 100.0))]
    if samples > LIMIT:
        used = [Parameter("USED", INT, (), integers([256], 84)), Parameter("RATE", FLOAT, (), rate(256 * 100.0))]
    file.groups = with_parameters(file.groups, "ANALOG", used)
    write_layout(file, tmp_path / "a.c3d")
    assert read_layout(tmp_path / "a.c3d").analog.shape == (4, 4 * samples)
    np.testing.assert_array_equal(io.read(tmp_path / "a.c3d").points, recording(4).points)


def rate(value):
    return np.array([value], "<f4").tobytes()


def with_rotations(frames):
    """A record of two blocks for each frame, and rotations behind the last."""
    file = fresh_layout(recording(frames, 64))
    start = Parameter("DATA_START", INT, (), integers([1], file.processor))
    file.groups = [*file.groups, Group(9, "ROTATION", parameters=[start])]
    file.tail = bytes(range(256)) * 8
    return file


@pytest.mark.parametrize("beyond", [-1, 0, 1, 900])
def test_where_rotations_start(tmp_path, beyond):
    write_layout(with_rotations(2), tmp_path / "small.c3d")
    first = read_layout(tmp_path / "small.c3d").number("POINT", "DATA_START")
    assert first is not None
    frames = (LIMIT + beyond - int(first)) // 2
    file = with_rotations(frames)
    write_layout(file, tmp_path / "a.c3d")
    back = read_layout(tmp_path / "a.c3d")
    assert back.number("ROTATION", "DATA_START") == first + 2 * frames
    assert back.tail == file.tail and len(back.points) == frames
    np.testing.assert_array_equal(back.points[-1], file.points[-1])


def with_parameters_of(size):
    """A file whose parameters have so many bytes."""
    file, rows = fresh_layout(recording()), 255
    while True:
        long = [Parameter(f"NOTES{k}", CHAR, (255, n), b"x" * 255 * n) for k, n in enumerate((255, rows))]
        file.groups = with_parameters(fresh_layout(recording()).groups, "ANALOG", [*long, text(0)])
        left = size - len(pack_parameters(file.groups, file.processor))
        if left >= 0:
            file.groups = with_parameters(file.groups, "ANALOG", [text(left)])
            return file
        rows -= 1


def text(length):
    return Parameter("FILL", CHAR, (length,), b"z" * length)


@pytest.mark.parametrize("beyond", [0, 1])
def test_blocks_of_parameters(tmp_path, beyond):
    """One byte counts them: 255 blocks, with four bytes of their own at the beginning."""
    file = with_parameters_of(255 * 512 - 4 + beyond)
    if beyond:
        with pytest.raises(io.WriteError, match="its parameters are longer than a C3D file allows"):
            write_layout(file, tmp_path / "a.c3d")
        return
    write_layout(file, tmp_path / "a.c3d")
    back = read_layout(tmp_path / "a.c3d")
    assert set("".join(back.strings("ANALOG", "FILL"))) <= {"z"} and len(back.points) == 2


def test_one_parameter_beyond_16_bits(tmp_path):
    """Where the next one starts is said in 16 bits."""
    file = fresh_layout(recording())
    long = Parameter("NOTES", CHAR, (255, 255, 2), b"x" * 255 * 255 * 2)
    file.groups = with_parameters(file.groups, "ANALOG", [long, Parameter("AFTER", INT, (), integers([1], 84))])
    with pytest.raises(io.WriteError, match="its parameters are longer than a C3D file allows"):
        write_layout(file, tmp_path / "a.c3d")


def test_frame_numbers_of_text_beyond_32_bits(tmp_path):
    rows = f"{10**12}\t0\t1\t2\t3\n{10**12 + 1}\t0.01\t1\t2\t4\n"
    head = (
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n100\t2\t1\tmm\nFrame#\tTime\tA\t\t\n"
    )
    (tmp_path / "a.trc").write_text(head + "\t\tX1\tY1\tZ1\n\n" + rows)
    io.write_labelled(make_labelling(io.read(tmp_path / "a.trc"), ["A"]), tmp_path / "out.c3d")
    assert io.first_frame(tmp_path / "out.c3d") == 1
