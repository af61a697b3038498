"""Recordings as ezc3d holds them: points as (4, points, frames), names and rate in the parameters."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from dshpm_jax._bridges.optional import distinct, optional
from dshpm_jax._recording import MILLIMETRES, Recording, bare_label


def from_c3d(c3d: Any) -> Recording:
    """What `Recording.from_ezc3d` returns."""
    points, parameters = np.asarray(c3d["data"]["points"], dtype=float), c3d["parameters"]["POINT"]
    if points.ndim != 3 or points.shape[0] not in (3, 4):
        raise ValueError(f"its points must have the shape (4, points, frames), got {points.shape}")
    unit = str(next(iter(_values(parameters, "UNITS")), "")).strip() or "mm"
    rate = float(next(iter(_values(parameters, "RATE")), np.nan))
    places = np.moveaxis(points[:3], 0, -1).swapaxes(0, 1)
    labels = (_labels(parameters) + [""] * points.shape[1])[: points.shape[1]]
    return Recording(places, tuple(map(bare_label, labels)), rate, unit, points_unit=unit)


def to_c3d(recording: Recording) -> Any:
    """What `Recording.to_ezc3d` returns."""
    c3d = optional("ezc3d", "to_ezc3d").c3d()
    places = recording.points / MILLIMETRES[recording.unit]
    homogeneous = np.ones((4, places.shape[1], places.shape[0]))
    homogeneous[:3] = np.moveaxis(places, -1, 0).swapaxes(1, 2)
    c3d["data"]["points"] = homogeneous
    parameters = c3d["parameters"]["POINT"]
    parameters["RATE"]["value"] = [float(recording.rate)]
    parameters["UNITS"]["value"] = [recording.unit]
    parameters["LABELS"]["value"] = distinct(recording.labels)
    return c3d


def _labels(parameters: Mapping[str, Any]) -> list[str]:
    """Those of LABELS, and beyond 255 of LABELS2, LABELS3 and so on."""
    found, name, number = [], "LABELS", 1
    while values := _values(parameters, name):
        found += [str(value) for value in values]
        number += 1
        name = f"LABELS{number}"
    return found


def _values(parameters: Mapping[str, Any], name: str) -> list[Any]:
    return list(parameters[name]["value"]) if name in parameters else []
