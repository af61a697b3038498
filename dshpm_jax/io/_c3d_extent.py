"""Where the records of a C3D file begin, how long they are and how many: header and parameters both say so, and where
they disagree the size of the file decides."""

import itertools
import struct
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dshpm_jax.io._c3d_parameters import byte_order, pack_parameters
from dshpm_jax.io._errors import ReadError

if TYPE_CHECKING:
    from pathlib import Path

    from dshpm_jax.io._c3d_format import C3dFile

BLOCK = 512
_FIELDS = {"points": "points", "samples": "analog samples a frame", "frames": "frames", "start": "block of its data"}
"""What people call what an `Extent` says."""

MAX_FRAMES_FIELD = 0xFFFF  # the 16-bit frame counts saturate here


class Extent(NamedTuple):
    """Records of a file: the block of the first (from 1), what is in each, the size of a number, and how many."""

    start: int
    points: int
    samples: int
    word: int
    frames: int = 0

    @property
    def bytes(self) -> int:
        """Of a record."""
        return (4 * self.points + self.samples) * self.word

    @property
    def size(self) -> int:
        """Of all records, in bytes."""
        return self.bytes * self.frames


class _Header(NamedTuple):
    """What the header says in its 16-bit numbers."""

    points: int
    samples: int
    first: int
    last: int
    start: int
    ratio: int

    @classmethod
    def of(cls, file: "C3dFile") -> "_Header":
        order = byte_order(file.processor)
        points, samples, first, last = struct.unpack(f"{order}4H", file.header[2:10])
        start, ratio = struct.unpack(f"{order}2H", file.header[16:20])
        return cls(points, samples, first, last, start, ratio)

    @property
    def frames(self) -> int:
        return self.last - self.first + 1 if self.last >= self.first and self.last > 0 else 0


def extent_of(file: "C3dFile", raw: np.ndarray, path: "Path") -> tuple[Extent, str]:
    """The records of a file whose header and parameters are known, and in what these disagree, if they do.

    Raises:
        ReadError: it ends before its frames do, or header and parameters disagree and its size fits neither.
    """
    header = _Header.of(file)
    told = list(_records(file, header, raw))
    if not told:
        raise ReadError(path, "it does not say where behind its parameters its data start", "export it again")
    counts = _counts(file, header)
    if len(set(told)) == 1 and len(counts) == 1:
        frames = _count_frames(file, header, told[0], raw, path) if told[0].bytes else 0
        return told[0]._replace(frames=frames), ""
    claims = [record._replace(frames=count) for record, count in itertools.product(told, counts)]
    found = _by_size(file, list(dict.fromkeys(claims)), raw)
    wrong = f"its header and its parameters disagree ({_disagreement(claims)})"
    if found is None:
        raise ReadError(path, f"{wrong}, and its size of {len(raw)} bytes fits neither", "export it again")
    return found, wrong


def _by_size(file: "C3dFile", claims: list[Extent], raw: np.ndarray) -> Extent | None:
    """The claim that fits the size of the file: its frames end in the last block, and what is left of that is empty;
    none where all leave something there, as then every number may be wrong.

    Of several it is the one that leaves nothing before the frames and the most behind them, all of it empty.
    """
    whole = [found for found in claims if _holds_data(file, found, raw)]
    empty = [found for found in whole if not _padding(file, found, raw).any()]
    last = [found for found in whole if len(_data(file, found, raw)) - found.size < BLOCK]
    if not last:  # something of unknown size comes after
        followed = [found for found in empty if len(_padding(file, found, raw))]
        return followed[0] if len(followed) == 1 else None
    clean = [found for found in last if found in empty]
    ranked = sorted(clean, key=lambda found: (found.start, found.size))
    alike = not ranked or len(ranked) > 1 and ranked[0].start == ranked[1].start and ranked[0].size == ranked[1].size
    return None if alike else ranked[0]


def _holds_data(file: "C3dFile", found: Extent, raw: np.ndarray) -> bool:
    """Whether the last of the records is there and not empty, as it is where a claim goes beyond the data."""
    data = _data(file, found, raw)
    return 0 < found.size <= len(data) and bool(data[found.size - found.bytes : found.size].any())


def _padding(file: "C3dFile", found: Extent, raw: np.ndarray) -> np.ndarray:
    """What stands between the last frame and the end of its block."""
    data = _data(file, found, raw)
    return data[found.size : -(-found.size // BLOCK) * BLOCK]


def _records(file: "C3dFile", header: _Header, raw: np.ndarray) -> Iterator[Extent]:
    """Every record that header and parameters may mean, what the header says first."""
    used, started = file.number("POINT", "USED"), file.number("POINT", "DATA_START")
    starts = (header.start or int(started or 0), int(started or header.start))
    behind = int(file.header[0]) + int(raw[(file.header[0] - 1) * BLOCK + 2])  # the parameters
    starts = tuple(start for start in starts if start >= behind) or starts  # that count of blocks may be wrong itself
    within = -(-(len(pack_parameters(file.groups, file.processor)) + 4) // BLOCK)
    starts = tuple(start for start in starts if start >= int(file.header[0]) + within)
    points = (header.points, header.points if used is None else int(used))
    words = [2 if scale > 0 else 4 for scale in (file.scale, file.number("POINT", "SCALE") or file.scale)]
    for start, some, more, word in itertools.product(starts, points, _samples(file, header), words):
        yield Extent(start, some, more, word)


def _samples(file: "C3dFile", header: _Header) -> list[int]:
    """Analog samples in a record: the header should count those, but some writers count channels there."""
    channels = file.number("ANALOG", "USED")
    if channels is None:
        return [header.samples]
    rate, analog = file.number("POINT", "RATE"), file.number("ANALOG", "RATE")
    ratio = analog / rate if analog and rate else float(header.ratio)
    told = int(channels) * round(ratio)
    if told == header.samples or not channels or not ratio or abs(ratio - round(ratio)) > 0.01 * ratio:
        return [header.samples] if channels or not header.samples else [header.samples, 0]
    return [header.samples, int(channels) * header.ratio, header.samples * round(ratio), told]


def _counts(file: "C3dFile", header: _Header) -> list[int]:
    """How many frames header and parameters may mean; none where 16 bits cannot say it and nothing else does."""
    counted, trial = file.number("POINT", "FRAMES"), _trial_frames(file)
    longest = int(max(file.number("POINT", "LONG_FRAMES") or 0, trial))
    if longest > MAX_FRAMES_FIELD:
        return [longest]
    if MAX_FRAMES_FIELD in (header.last, counted) or counted is None or counted == header.frames:
        return [header.frames]
    if not header.frames:
        return [int(counted)]
    return [header.frames, int(counted)]


def _data(file: "C3dFile", record: Extent, raw: np.ndarray) -> np.ndarray:
    """The bytes from the first frame on, up to rotations that stand behind the last one."""
    rotations = (int(file.number("ROTATION", "DATA_START") or 0) - 1) * BLOCK
    begin = (record.start - 1) * BLOCK
    return raw[begin : rotations if begin < rotations <= len(raw) else len(raw)]


def _disagreement(told: list[Extent]) -> str:
    """What does not fit, in numbers of the header and of a parameter."""
    parts = []
    for field, name in _FIELDS.items():
        values = dict.fromkeys(getattr(one, field) for one in told)
        if len(values) > 1:
            parts.append(f"{name}: {' or '.join(map(str, values))}")
    return ", ".join(parts) or "the size of a number: 2 or 4 bytes"


def _count_frames(file: "C3dFile", header: _Header, record: Extent, raw: np.ndarray, path: "Path") -> int:
    """How many frames the file holds: its 16-bit counts cannot say more than 65,535."""
    data = raw[(record.start - 1) * BLOCK :]
    room = len(data) // record.bytes
    counted = file.number("POINT", "FRAMES")
    declared = header.frames or int(counted or 0)
    longer = [file.number("POINT", "LONG_FRAMES") or 0, _trial_frames(file)]
    longest = int(max(longer))
    if MAX_FRAMES_FIELD < longest <= room:
        return longest
    if counted is not None and 0 < counted < MAX_FRAMES_FIELD and counted == longer[1] and counted <= room:
        return int(counted)  # a piece of a longer capture, whose last frame has a number beyond the header's 16 bits
    if header.last == MAX_FRAMES_FIELD or counted == MAX_FRAMES_FIELD:
        return _without_padding(data, record.bytes, room, declared)
    if declared > room:
        remedy = "copy or export it again"
        raise ReadError(path, f"it announces {declared} frames and ends after {room} (truncated)", remedy)
    return declared


def _trial_frames(file: "C3dFile") -> int:
    """Frames between TRIAL:ACTUAL_START_FIELD and ACTUAL_END_FIELD, two 16-bit words each, the lower first."""
    ends = [file.find("TRIAL", f"ACTUAL_{end}_FIELD") for end in ("START", "END")]
    values = [p.numbers(file.processor) if p is not None else [] for p in ends]
    if not all(len(v) == 2 for v in values):
        return 0
    start, stop = (low + 65536 * high for low, high in values)
    return int(stop - start + 1)


def _without_padding(data: np.ndarray, frame_bytes: int, room: int, least: int) -> int:
    """Frames up to the end of the file, less the empty ones in its last block, which may be padding."""
    frames = room
    while frames > least and (room - frames + 1) * frame_bytes < BLOCK:
        if data[(frames - 1) * frame_bytes : frames * frame_bytes].any():
            break
        frames -= 1
    return frames
