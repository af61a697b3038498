"""The layout of a C3D file: header, parameters, then a record of fixed length for each frame.

We read and write the bytes ourselves, so that whatever labelling has no business with (analog samples, events,
integer formats, unknown groups) comes out exactly as it went in, files with more than 65,535 frames keep them all,
and a damaged file is an error and never a crash.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Shaped, UInt8

from dshpm_jax.io._atomic import write_whole
from dshpm_jax.io._c3d_extent import BLOCK, MAX_FRAMES_FIELD, extent_of
from dshpm_jax.io._c3d_parameters import (
    CHAR,
    DEC,
    FLOAT,
    INT,
    INTEL,
    MIPS,
    Group,
    Parameter,
    byte_order,
    decode_floats,
    encode_floats,
    integers,
    pack_parameters,
    unpack_parameters,
    with_parameters,
)
from dshpm_jax.io._errors import ReadError, WriteError

MAX_PARAMETER_BLOCKS = 255


@dataclass
class C3dFile:
    """A C3D file in memory.

    Attributes:
        header: its first 512 bytes.
        processor: INTEL, DEC or MIPS: how numbers are stored.
        groups: the parameters.
        points: the record of each point, opaque bytes of `record_bytes`.
        analog: all that follows the points in each frame's record.
        tail: what follows the last frame (from the next block on).
        disagreement: of header and parameters about the records, where the size of the file had to decide.
    """

    header: bytes
    processor: int
    groups: list[Group]
    points: Shaped[np.ndarray, "frames points"]
    analog: UInt8[np.ndarray, "frames analog_bytes"]
    tail: bytes = b""
    disagreement: str = ""

    @property
    def scale(self) -> float:
        """The length of one count in the file's unit; not positive in a file of floating point numbers."""
        return float(decode_floats(np.frombuffer(self.header[12:16], np.uint8), self.processor)[0])

    @property
    def count(self) -> float:
        """The length of one count in a file of 16-bit numbers, by the header or else by POINT:SCALE."""
        return self.scale if self.scale > 0 else self.number("POINT", "SCALE") or 0.0

    def find(self, group: str, name: str) -> Parameter | None:
        for g in self.groups:
            if g.name.upper() == group:
                for p in g.parameters:
                    if p.name.upper() == name:
                        return p
        return None

    def strings(self, group: str, name: str) -> list[str]:
        """Texts of a parameter and of its continuations (`LABELS2`, ...)."""
        found, k, here = [], 1, self.find(group, name)
        while here is not None:
            found += here.strings() if here.kind == CHAR else []
            k, here = k + 1, self.find(group, f"{name}{k + 1}")
        return found

    def number(self, group: str, name: str) -> float | None:
        """The first value of a parameter, if it is there and has any."""
        here = self.find(group, name)
        values = here.numbers(self.processor) if here is not None else []
        return values[0] if values else None


def missing_record(file: C3dFile) -> np.void:
    """The record of a point that was not seen: zeros and a residual of -1, in the file's own numbers."""
    if file.points.dtype.itemsize == 8:
        raw = integers([0, 0, 0, 0xFFFF], file.processor)
    else:
        raw = encode_floats([0.0, 0.0, 0.0, -1.0], file.processor)
    return np.frombuffer(raw, file.points.dtype)[0]


def read_layout(path: Path) -> C3dFile:
    """Reads a C3D file; raises `ReadError` for anything that is none, or not a whole one."""
    try:
        size = path.stat().st_size
        raw = np.memmap(path, np.uint8, "r") if size else np.zeros(0, np.uint8)
    except OSError as error:
        raise ReadError(path, f"cannot be read ({error.strerror})", "check the path and its permissions") from None
    if not size:
        raise ReadError(path, "the file is empty", "export it again")
    if size < BLOCK or raw[1] != 0x50:
        raise ReadError(path, "this is no C3D file", "give a C3D or TRC file")
    try:
        return _parse(raw, path)
    except (IndexError, struct.error, ValueError, OverflowError) as error:
        if isinstance(error, ReadError):
            raise
        raise ReadError(path, "its parameter section is damaged", "export it again") from None


def write_layout(file: C3dFile, path: Path) -> None:
    """Writes a C3D file, whole or not at all."""
    if file.points.shape[1] > 0xFFFF:
        raise WriteError(path, f"{file.points.shape[1]} points are more than a C3D file holds", "leave some out")
    try:
        parameter_blocks = _blocks(len(pack_parameters(_with_starts(file, 0, 1 << 16), file.processor)) + 4)
    except struct.error:  # a count or a length beyond 16 bits
        parameter_blocks = MAX_PARAMETER_BLOCKS + 1
    if parameter_blocks > MAX_PARAMETER_BLOCKS:
        raise WriteError(path, "its parameters are longer than a C3D file allows", "shorten labels and descriptions")
    write_whole(path, _chunks(file, parameter_blocks))


def _chunks(file: C3dFile, parameter_blocks: int) -> Iterator[bytes | memoryview]:
    """The bytes of the file, frames some at a time."""
    data_start = 2 + parameter_blocks
    frames, points = file.points.shape
    frame_bytes = points * file.points.dtype.itemsize + file.analog.shape[1]
    tail_start = data_start + _blocks(frames * frame_bytes)
    groups = _with_starts(file, data_start, tail_start)
    header = bytearray(file.header)
    header[0] = 2
    header[2:4] = integers([points], file.processor)
    header[16:18] = integers([data_start], file.processor)
    samples = 4 * file.analog.shape[1] // file.points.dtype.itemsize
    if samples <= 0xFFFF:  # some writers count channels there, and readers believe them
        header[4:6] = integers([samples], file.processor)
    yield bytes(header)
    packed = bytes([1, 0x50, parameter_blocks, file.processor]) + pack_parameters(groups, file.processor)
    yield packed.ljust(parameter_blocks * BLOCK, b"\0")
    step = max(1, (1 << 24) // max(1, frame_bytes))
    for k in range(0, frames, step):
        part = np.ascontiguousarray(file.points[k : k + step])
        rows = part.view(np.uint8).reshape(len(part), -1)
        yield np.concatenate([rows, file.analog[k : k + step]], axis=1).tobytes()
    # Where the 16-bit counts end, some readers take all that is there for frames, so nothing fills the last block.
    if frames < MAX_FRAMES_FIELD or file.tail:
        yield bytes(-(frames * frame_bytes) % BLOCK)
    yield file.tail


def _with_starts(file: C3dFile, data_start: int, tail_start: int) -> list[Group]:
    """The parameters with the places of the data as they are in the new file."""
    groups = with_parameters(file.groups, "POINT", [_start_of(data_start, file.processor)])
    if file.tail and file.number("ROTATION", "DATA_START"):  # rotations stand behind the last frame
        groups = with_parameters(groups, "ROTATION", [_start_of(tail_start, file.processor)])
    return groups


def _start_of(block: int, processor: int) -> Parameter:
    """DATA_START; beyond 16 bits as a floating point number, as LONG_FRAMES is, since nothing else holds it."""
    if block > 0xFFFF:
        return Parameter("DATA_START", FLOAT, (), encode_floats([block], processor))
    return Parameter("DATA_START", INT, (), integers([block], processor))


def _parse(raw: np.ndarray, path: Path) -> C3dFile:
    header = raw[:BLOCK].tobytes()
    begin = (header[0] - 1) * BLOCK
    if begin != BLOCK and not BLOCK < begin <= len(raw) - 4:  # the parameters follow the header in nearly every file
        raise ReadError(path, "this is no C3D file", "give a C3D or TRC file")
    if begin + 4 > len(raw):
        raise ReadError(path, "it ends before its parameters (truncated)", "copy or export it again")
    blocks, processor = int(raw[begin + 2]), int(raw[begin + 3])
    if processor not in (INTEL, DEC, MIPS):
        wrong = f"this is no C3D file, or a damaged one (unknown processor type {processor})"
        raise ReadError(path, wrong, "give a C3D or TRC file, or export it again")
    file = C3dFile(header, processor, [], np.zeros((0, 0)), np.zeros((0, 0), np.uint8))
    start_block = struct.unpack(f"{byte_order(processor)}H", header[16:18])[0]
    end = max(begin + blocks * BLOCK, (start_block - 1) * BLOCK)  # some writers leave the count of blocks at zero
    if end > len(raw):
        raise ReadError(path, "it ends within its parameters (truncated)", "copy or export it again")
    file.groups = unpack_parameters(raw[begin + 4 : end].tobytes(), processor)
    found, file.disagreement = extent_of(file, raw, path)
    data = raw[(found.start - 1) * BLOCK :]
    records = data[: found.size].reshape(found.frames, found.bytes)
    point_bytes = 4 * found.points * found.word
    raw_points = np.ascontiguousarray(records[:, :point_bytes])
    file.points = raw_points.view(f"V{4 * found.word}").reshape(found.frames, found.points)
    file.analog = records[:, point_bytes:]
    file.tail = data[_blocks(found.size) * BLOCK :].tobytes()
    return file


def _blocks(size: int) -> int:
    return -(-size // BLOCK)
