"""Dataclasses to JSON values and back, by their annotations, so that a new field needs no code here."""

import dataclasses
import types
import typing
from collections.abc import Mapping
from typing import Any

import numpy as np

DECIMALS = 4  # of millimetres: far below any capture system's noise


def encode(value: Any) -> Any:
    """Plain JSON values; arrays are lists of rows with null for NaN."""
    if dataclasses.is_dataclass(value):
        return {f.name: encode(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, np.ndarray):
        return encode(value.tolist())
    if isinstance(value, float | np.floating):
        return round(float(value), DECIMALS) if np.isfinite(value) else None
    if isinstance(value, list | tuple):
        return [encode(item) for item in value]
    if isinstance(value, Mapping):
        return {str(key): encode(item) for key, item in value.items()}
    return value.item() if isinstance(value, np.generic) else value


def decode(kind: Any, value: Any, place: str, sizes: Mapping[str, int]) -> Any:
    """The inverse of `encode`.

    Arguments:
        kind: what the value is to be: a dataclass, a jaxtyping array (of floats), `tuple[X, ...]`, `dict[str, X]`,
            `X | None`, or a plain type.
        place: where in the file the value stands, for messages.
        sizes: lengths of the axes that are known; arrays must have them.

    Raises ValueError with `place` and what is wrong there.
    """
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return None if value is None else decode(next(k for k in inner if k is not types.NoneType), value, place, sizes)
    if dataclasses.is_dataclass(kind) and isinstance(kind, type):
        return _decode_dataclass(kind, value, place, sizes)
    if hasattr(kind, "dim_str"):
        return _decode_array(kind, value, place, sizes)
    if origin is tuple:
        items = _expect(list, value, place)
        return tuple(decode(inner[0], item, f"{place}[{k}]", sizes) for k, item in enumerate(items))
    if origin is dict:
        return {k: decode(inner[1], v, f"{place}.{k}", sizes) for k, v in _expect(dict, value, place).items()}
    if kind is float:
        return np.nan if value is None else float(_expect((int, float), value, place))
    return _expect(kind, value, place)


def _decode_dataclass(kind: type, value: Any, place: str, sizes: Mapping[str, int]) -> Any:
    found = _expect(dict, value, place)
    fields = {f.name: f for f in dataclasses.fields(kind)}
    if unknown := sorted(found.keys() - fields.keys()):
        raise ValueError(f"{place} has an unknown entry '{unknown[0][:40]}'")
    optional = {n for n, f in fields.items() if not _required(f)}
    if lacking := [name for name in fields if name not in found and name not in optional]:
        raise ValueError(f"{place} has no '{lacking[0]}'")
    if isinstance(found.get("markers"), list):  # the axis that arrays beside it are measured in
        names = ("segment_markers", "neighbours") if "markers" in sizes else ("markers",)
        sizes = {**sizes, **dict.fromkeys(names, len(found["markers"]))}
    hints = typing.get_type_hints(kind)
    return kind(**{name: decode(hints[name], item, f"{place}.{name}", sizes) for name, item in found.items()})


def _decode_array(kind: Any, value: Any, place: str, sizes: Mapping[str, int]) -> np.ndarray:
    try:
        array = np.array(_expect(list, value, place), dtype=np.float64)  # None becomes NaN
    except (TypeError, ValueError):
        raise ValueError(f"{place} is no table of numbers") from None
    axes = kind.dim_str.split()
    wanted = tuple(_length(axis, sizes) for axis in axes)
    if array.size == 0 and (0 in wanted or wanted[0] is None):
        array = array.reshape([n or 0 for n in wanted])
    if array.ndim != len(axes) or any(n not in (None, m) for n, m in zip(wanted, array.shape, strict=True)):
        raise ValueError(f"{place} has the shape {array.shape}, expected {wanted}")
    return array


def _length(axis: str, sizes: Mapping[str, int]) -> int | None:
    """The length of an axis such as `3`, `markers` or `neighbours+1`; None where it may be any."""
    name, _, more = axis.partition("+")
    known = int(name) if name.isdigit() else sizes.get(name)
    return known if known is None else known + int(more or 0)


def _required(field: dataclasses.Field) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def _expect(kind: Any, value: Any, place: str) -> Any:
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        names = {list: "a list", dict: "an object", str: "a text", int: "a whole number", bool: "true or false"}
        shown = "nothing" if value is None else repr(value)
        raise ValueError(f"{place} is {shown[:40]}, expected {names.get(kind, 'a number')}")
    return value
