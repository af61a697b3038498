"""Damage to the bytes of a file: cut short, turned over, exchanged, repeated, fields and words at their extremes."""

import numpy as np

EXTREMES = (0, 1, 2, 0x50, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
FLOATS = (0.0, -1.0, 1e-38, 1e38, -1e38, np.inf, -np.inf, np.nan)
NUMBERS = ("", "0", "-1", "nan", "inf", "1e308", "-1e308", "1e-308", "99999999999999999999", "1,5", "0x10", "\u0663")
WORDS = (*NUMBERS, "true", "null", "{}", "[]", '"', "'", "<", "&a;", "\0", "\u2028", "a" * 5000)
NESTED = 20_000


def damage_bytes(data: bytes, text: bool, rng: np.random.Generator) -> bytes:
    """The bytes of a file after one to three kinds of damage."""
    ways = BINARY[:4] + TEXT if text else BINARY
    for _ in range(int(rng.integers(1, 4))):
        data = ways[int(rng.integers(len(ways)))](data, rng)
    return data


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: int(rng.integers(len(data) + 1))]


def _flip(data: bytes, rng: np.random.Generator) -> bytes:
    broken = bytearray(data)
    for at in rng.integers(0, max(len(data), 1), int(2 ** rng.integers(0, 8))) if data else ():
        broken[at] ^= 1 << int(rng.integers(8))
    return bytes(broken)


def _exchange(data: bytes, rng: np.random.Generator) -> bytes:
    a, b, c, d = np.sort(rng.integers(0, len(data) + 1, 4)).tolist()
    return data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:]


def _repeat(data: bytes, rng: np.random.Generator) -> bytes:
    a, b = np.sort(rng.integers(0, len(data) + 1, 2)).tolist()
    return (
        data[:b] + data[a:b][:50_000] * int(rng.integers(1, 4)) + data[b:]
        if rng.random() < 0.5
        else data[:a] + data[b:]
    )


def _field(data: bytes, rng: np.random.Generator) -> bytes:
    """A field of the header or the parameters at an extreme."""
    size, order = int(2 ** rng.integers(0, 3)), "little" if rng.random() < 0.7 else "big"
    at = int(rng.integers(0, 24 if rng.random() < 0.5 else 2048))
    value = int(rng.choice(EXTREMES)) % (1 << 8 * size)
    return data[:at] + value.to_bytes(size, order) + data[at + size :]


def _float(data: bytes, rng: np.random.Generator) -> bytes:
    at = 4 * int(rng.integers(0, max(1, len(data) // 4)))
    return data[:at] + np.float32(rng.choice(FLOATS)).tobytes() + data[at + 4 :]


def _lines(data: bytes, rng: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    a, b = (int(k) for k in rng.integers(0, len(lines), 2))
    kind = int(rng.integers(3))
    if kind == 0:
        lines[a], lines[b] = lines[b], lines[a]
    elif kind == 1:
        del lines[min(a, b) : max(a, b)]
    else:
        lines.insert(a, lines[b])
    return b"\n".join(lines)


def _word(data: bytes, rng: np.random.Generator) -> bytes:
    """A cell, number or name as something else."""
    ends = [k for k, byte in enumerate(data) if byte in b' \t\n,;:="<>[]{}']
    if len(ends) < 2:
        return data
    k = int(rng.integers(len(ends) - 1))
    return data[: ends[k] + 1] + str(rng.choice(WORDS)).encode() + data[ends[k + 1] :]


def _nest(data: bytes, rng: np.random.Generator) -> bytes:
    """Brackets or elements within each other, thousands deep."""
    at = int(rng.integers(len(data) + 1))
    return data[:at] + (b"[", b"{", b'{"a":', b"<Segment>", b"<objects>")[int(rng.integers(5))] * NESTED + data[at:]


def _entity(data: bytes, rng: np.random.Generator) -> bytes:
    bomb = b'<!DOCTYPE a [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    at = data.find(b"?>") + 2 if rng.random() < 0.8 else 0
    return data[:at] + bomb + data[at:]


BINARY = (_cut, _flip, _exchange, _repeat, _field, _float, _field)
TEXT = (_lines, _lines, _word, _word, _word, _nest, _entity)
