"""The parameter section of a C3D file: groups of named arrays, and its three ways to store numbers."""

import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float32, UInt8

INTEL, DEC, MIPS = 84, 85, 86
CHAR, BYTE, INT, FLOAT = -1, 1, 2, 4
MAX_NAMES = 255  # a parameter's dimension is one byte: more names go on in LABELS2, LABELS3, ...


@dataclass(frozen=True)
class Parameter:
    """A named array: `kind` is CHAR, BYTE, INT or FLOAT, `shape` has the fastest axis first, `data` are its bytes."""

    name: str
    kind: int
    shape: tuple[int, ...]
    data: bytes
    description: bytes = b""
    locked: bool = False

    def strings(self) -> list[str]:
        """Its texts without padding, a text for each row."""
        width = self.shape[0] if self.shape else 1
        if not width:
            return [""] * int(np.prod(self.shape[1:]))
        rows = [self.data[k : k + width] for k in range(0, len(self.data), width)]
        return [_decode(row).strip(" \0") for row in rows]

    def numbers(self, processor: int) -> list[float]:
        """Its values; integers of 16 bits as unsigned, since counts are what we read from them."""
        if self.kind == CHAR:
            return []
        if self.kind == FLOAT:
            return decode_floats(np.frombuffer(self.data, np.uint8), processor).tolist()
        code = "u1" if self.kind == BYTE else byte_order(processor) + "u2"
        return np.frombuffer(self.data, code).astype(float).tolist()


@dataclass
class Group:
    """A group of parameters with the number by which the file knows it."""

    number: int
    name: str
    description: bytes = b""
    locked: bool = False
    parameters: list[Parameter] = field(default_factory=list)


def decode_floats(raw: UInt8[np.ndarray, "..."], processor: int) -> Float32[np.ndarray, "..."]:
    """Single-precision numbers from bytes (last axis)."""
    raw = np.ascontiguousarray(raw)
    if processor != DEC:
        with np.errstate(invalid="ignore"):
            return raw.view(byte_order(processor) + "f4").astype(np.float32)
    # A VAX F-float is an IEEE one with its 16-bit halves exchanged and an exponent that is larger by two.
    halves = raw.view("<u2").reshape(*raw.shape[:-1], -1, 2)
    with np.errstate(invalid="ignore"):  # bytes that are no number
        return np.ascontiguousarray(halves[..., ::-1]).view("<f4")[..., 0] / np.float32(4)


def encode_floats(values: Sequence[float], processor: int) -> bytes:
    """The inverse of `decode_floats`."""
    if processor != DEC:
        return np.asarray(values, byte_order(processor) + "f4").tobytes()
    halves = (np.asarray(values, "<f4") * np.float32(4)).view("<u2").reshape(-1, 2)
    return np.ascontiguousarray(halves[:, ::-1]).tobytes()


def integers(values: Sequence[int], processor: int) -> bytes:
    """16-bit integers as bytes; values from 32,768 on go in as unsigned."""
    return struct.pack(f"{byte_order(processor)}{len(values)}H", *values)


def text_parameters(name: str, texts: Sequence[str]) -> list[Parameter]:
    """`texts` as a parameter, continued as NAME2, NAME3, ... beyond 255."""
    rows = [text.encode()[:MAX_NAMES] for text in texts]
    made = []
    for k in range(0, max(len(rows), 1), MAX_NAMES):
        part = rows[k : k + MAX_NAMES]
        width = max([1, *map(len, part)])
        data = b"".join(row.ljust(width) for row in part)
        made.append(Parameter(name if not k else f"{name}{k // MAX_NAMES + 1}", CHAR, (width, len(part)), data))
    return made


def with_parameters(groups: Sequence[Group], group: str, new: Sequence[Parameter], drop: str = "") -> list[Group]:
    """A copy of `groups` where `group` holds `new` instead of those of the same names and those that match `drop`.

    A new parameter stands where the old one stood and keeps its description, or else comes last.
    """
    changed = []
    for g in groups:
        if g.name.upper() == group:
            waiting = {p.name: p for p in new}
            kept = []
            for old in g.parameters:
                if old.name.upper() in waiting:
                    made = waiting.pop(old.name.upper())
                    kept.append(replace(made, name=old.name, description=old.description, locked=old.locked))
                elif not (drop and re.fullmatch(drop, old.name.upper())):
                    kept.append(old)
            g = replace(g, parameters=[*kept, *waiting.values()])
        changed.append(g)
    return changed


def unpack_parameters(raw: bytes, processor: int) -> list[Group]:
    groups: dict[int, Group] = {}
    at = 0
    while at + 2 <= len(raw) and raw[at] != 0:
        length, number = struct.unpack_from("bb", raw, at)
        name = raw[at + 2 : at + 2 + abs(length)].decode("latin-1")
        at += 2 + abs(length)
        (step,) = struct.unpack_from(byte_order(processor) + "H", raw, at)
        body = raw[at + 2 : at + step] if step else raw[at + 2 :]
        group = groups.setdefault(abs(number), Group(abs(number), ""))
        if number < 0:
            group.name, group.locked = name, length < 0
            group.description = body[1 : 1 + body[0]] if body else b""
        else:
            group.parameters.append(_unpack_parameter(name, length < 0, body))
        if not step:
            break
        at += step
    return list(groups.values())


def _unpack_parameter(name: str, locked: bool, body: bytes) -> Parameter:
    kind, axes = struct.unpack_from("bB", body, 0)
    if kind not in (CHAR, BYTE, INT, FLOAT):
        raise ValueError(f"unknown kind {kind} of parameter {name}")
    shape = tuple(body[2 : 2 + axes])
    size = int(np.prod(shape)) * abs(kind)
    data = body[2 + axes : 2 + axes + size]
    if len(data) < size:
        raise ValueError(f"parameter {name} is cut short")
    rest = body[2 + axes + size :]
    return Parameter(name, kind, shape, data, rest[1 : 1 + rest[0]] if rest else b"", locked)


def pack_parameters(groups: Sequence[Group], processor: int) -> bytes:
    entries: list[tuple[bytes, bytes]] = []
    for g in groups:
        entries.append((_named(g.name, -g.number, g.locked), bytes([len(g.description)]) + g.description))
        for p in g.parameters:
            body = struct.pack("bB", p.kind, len(p.shape)) + bytes(p.shape) + p.data
            entries.append((_named(p.name, g.number, p.locked), body + bytes([len(p.description)]) + p.description))
    last = len(entries) - 1
    return b"".join(
        head + integers([0 if k == last else len(body) + 2], processor) + body for k, (head, body) in enumerate(entries)
    )


def _named(name: str, number: int, locked: bool) -> bytes:
    raw = name.encode("latin-1")
    return struct.pack("bb", -len(raw) if locked else len(raw), number) + raw


def _decode(raw: bytes) -> str:
    try:
        return raw.decode()
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def byte_order(processor: int) -> str:
    """How `struct` and numpy spell the byte order of a processor's integers."""
    return ">" if processor == MIPS else "<"
