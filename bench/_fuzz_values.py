"""Damage that leaves a file well-formed: values of a model, of settings and of segments at their extremes.

What it makes is JSON or TOML as ever, so that it gets past the parser and often past every check.
"""

import json
import math
import tomllib
from collections.abc import Callable
from typing import Any

import numpy as np

from dshpm_jax._settings import RANGES

EXTREMES: tuple[Any, ...] = (
    *(None, True, 0, 1, -1, 0.5, -0.0, 1e-308, 1e-4, 3e4, 1e20, 1e308, -1e308, math.nan, math.inf, -math.inf),
    *(2**31, 2**63, 10**30, "", "nan", "*1", "a\nb", "a" * 3000, [], [[]], [None], {}, {"a": 1}),
)
SCALES = (0.0, 1e-9, 1e-3, 0.5, 2.0, 1e3, 1e6, 1e150)
LENGTHS = (0.0, 1e-9, 1.0, 1e4, 1e9, 1e38, 1e300, math.nan, math.inf)
TABLES = ("pair_mean", "pair_spread")


def damage_values(data: bytes, suffix: str, rng: np.random.Generator) -> bytes:
    """A model (`.json`), or settings or segments (`.toml`), with one to three of its values damaged."""
    model = suffix == ".json"
    found = json.loads(data) if model else tomllib.loads(data.decode())
    ways = (*ANYWHERE, *(OF_A_MODEL if model else OF_SETTINGS if "method" in found else OF_SEGMENTS))
    for _ in range(int(_choice(rng, (1, 1, 2, 3)))):
        try:
            ways[int(rng.integers(len(ways)))](found, rng)
        except (AttributeError, IndexError, KeyError, TypeError, ValueError):
            pass  # what it would damage is damaged already
    return (json.dumps(found) if model else _toml(found)).encode()


def _toml(table: dict[str, Any]) -> str:
    return "\n".join(f"{json.dumps(key)} = {_toml_value(value)}" for key, value in table.items()) + "\n"


def _toml_value(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_toml_value(item) for item in value)}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{json.dumps(key)} = {_toml_value(item)}' for key, item in value.items())}}}"
    if value is None:  # there is no such value
        return '"none"'
    return json.dumps(value).replace("Infinity", "inf").replace("NaN", "nan")


def _choice(rng: np.random.Generator, items: Any) -> Any:
    return items[int(rng.integers(len(items)))]


def _place(value: Any, rng: np.random.Generator) -> tuple[Any, Any]:
    """A list or object somewhere in `value`, and a key of it."""
    while True:
        key = _choice(rng, list(value) if isinstance(value, dict) else range(len(value)))
        if not isinstance(value[key], list | dict) or not value[key] or rng.random() < 0.3:
            return value, key
        value = value[key]


def _replace(found: Any, rng: np.random.Generator) -> None:
    where, key = _place(found, rng)
    where[key] = _choice(rng, EXTREMES)


def _scale(found: Any, rng: np.random.Generator) -> None:
    where, key = _place(found, rng)
    where[key] = _scaled(where[key], _choice(rng, SCALES))


def _scaled(value: Any, by: float) -> Any:
    """All numbers with a fraction in `value` times `by`."""
    if isinstance(value, list):
        return [_scaled(item, by) for item in value]
    if isinstance(value, dict):
        return {key: _scaled(item, by) for key, item in value.items()}
    return value * by if isinstance(value, float) else value


def _remove(found: Any, rng: np.random.Generator) -> None:
    where, key = _place(found, rng)
    del where[key]


def _repeat(found: Any, rng: np.random.Generator) -> None:
    where, key = _place(found, rng)
    if isinstance(where, list):
        where.insert(int(rng.integers(len(where) + 1)), where[key])
    else:
        where[f"{key} again"] = where[key]


def _exchange(found: Any, rng: np.random.Generator) -> None:
    where, key = _place(found, rng)
    other = _choice(rng, list(where) if isinstance(where, dict) else range(len(where)))
    where[key], where[other] = where[other], where[key]


def _copy_over(found: Any, rng: np.random.Generator) -> None:
    """Some value stands in the place of another."""
    (source, a), (target, b) = _place(found, rng), _place(found, rng)
    target[b] = json.loads(json.dumps(source[a]))


def _pairs(model: Any, rng: np.random.Generator) -> None:
    """A pair of markers, all pairs of one, or all pairs, with another distance; the table stays symmetric."""
    table, value = model[_choice(rng, TABLES)], _choice(rng, LENGTHS)
    one, other = (int(m) for m in rng.integers(0, len(table), 2))
    kind = int(rng.integers(3))
    for a in range(len(table)) if kind == 2 else [one]:
        for b in [other] if kind == 0 else range(len(table)):
            table[a][b] = table[b][a] = value


def _parent(model: Any, rng: np.random.Generator) -> None:
    segment = _choice(rng, model["segments"])
    segment["parent"] = int(rng.integers(-2, len(model["segments"]) + 1))
    segment["join"] = segment["join"] if rng.random() < 0.3 else []


def _flatten(model: Any, rng: np.random.Generator) -> None:
    """The places of a segment's or a neighbourhood's markers all in one point, on a line, or far away."""
    where = _choice(rng, model[_choice(rng, ("segments", "neighbourhoods"))])
    kind, number = int(rng.integers(3)), float(_choice(rng, LENGTHS))
    where["shape"] = [[0.0] * 3 if kind == 0 else [x, 0.0, 0.0] if kind == 1 else [number] * 3
                      for x, _, _ in where["shape"]]  # fmt: skip


def _membership(model: Any, rng: np.random.Generator) -> None:
    """A segment loses a marker or takes another's in, places and joins included."""
    segment = _choice(rng, model["segments"])
    places = dict(zip(segment["markers"], segment["shape"], strict=True))
    if rng.random() < 0.5:
        places.pop(_choice(rng, segment["markers"]))
    else:
        places[int(rng.integers(len(model["markers"])))] = rng.normal(0, 100, 3).tolist()
    segment["markers"], segment["shape"] = sorted(places), [places[m] for m in sorted(places)]
    for one in model["segments"]:
        one["join"] = [m for m in one["join"] if m in segment["markers"]]


def _one_segment(model: Any, rng: np.random.Generator) -> None:
    """All markers in one segment, or each in its own."""
    markers = range(len(model["markers"]))
    groups = [list(markers)] if rng.random() < 0.5 else [[m] for m in markers]
    model["segments"] = [
        {"name": f"s{k}", "markers": group, "shape": rng.normal(0, 100, (len(group), 3)).tolist()}
        for k, group in enumerate(groups)
    ]


def _names(model: Any, rng: np.random.Generator) -> None:
    where = _choice(rng, (model["markers"], model["sources"]))
    where[int(rng.integers(len(where)))] = _choice(rng, ("", "*1", " ", "a:b", "a\nb", "\0", "\ud800", "a" * 3000))


def _no_neighbours(model: Any, rng: np.random.Generator) -> None:
    if rng.random() < 0.5:
        model["neighbourhoods"] = []
        return
    near = _choice(rng, model["neighbourhoods"])
    near.update(markers=[], shape=near["shape"][-1:], distance_sd=[])


def _setting(settings: Any, rng: np.random.Generator) -> None:
    """A setting at the end of its range, or just beyond."""
    name = _choice(rng, list(RANGES))
    low, high = RANGES[name]
    settings[name] = _choice(rng, (low, high, low, high, low - 1, high + 1, float(low), -high))


def _method(settings: Any, rng: np.random.Generator) -> None:
    settings["method"] = _choice(rng, ("paper", "static", "full"))


def _group(segments: Any, rng: np.random.Generator) -> None:
    """A segment loses a marker, takes in another's, or hangs from some segment."""
    segment, other = (_choice(rng, list(segments.values())) for _ in range(2))
    kind = int(rng.integers(3))
    if kind == 0:
        segment["markers"].pop()
    elif kind == 1:
        segment["markers"].append(_choice(rng, other["markers"]))
    else:
        segment["parent"] = _choice(rng, list(segments))


Way = Callable[[Any, np.random.Generator], None]
ANYWHERE: tuple[Way, ...] = (_replace, _replace, _scale, _remove, _repeat, _exchange, _copy_over)
OF_SETTINGS: tuple[Way, ...] = (_setting, _setting, _setting, _setting, _method, _method)
OF_SEGMENTS: tuple[Way, ...] = (_group, _group, _group, _group, _group)
OF_A_MODEL: tuple[Way, ...] = (_pairs, _pairs, _parent, _flatten, _membership, _one_segment, _names, _no_neighbours)
