"""Recordings as kineticstoolkit's TimeSeries: times in seconds, and for each marker an array (frames, 4)."""

import re
from typing import Any

import numpy as np

from dshpm_jax._bridges.optional import distinct, optional
from dshpm_jax._recording import MILLIMETRES, Recording, bare_label

UNIT = "m"
"""In which kineticstoolkit holds points, unless `data_info` says otherwise."""

_NAMELESS = re.compile(r"_\d+")
"""What kineticstoolkit calls columns whose name is empty."""

_UNEVEN = 0.01
"""share of the time between two frames by which a frame may come early or late"""


def from_time_series(series: Any, rate: float | None = None) -> Recording:
    """What `Recording.from_kineticstoolkit` returns."""
    data = {name: np.asarray(values) for name, values in series.data.items()}
    frames = len(series.time)
    markers = {name: values for name, values in data.items() if values.shape == (frames, 4)}
    if not markers:
        raise ValueError("none of its data is an array (frames, 4) of points; give the TimeSeries of the points")
    units = {name: (series.data_info.get(name) or {}).get("Unit") or UNIT for name in markers}
    for name, unit in units.items():
        if unit not in MILLIMETRES:
            raise ValueError(f"the unit of '{name}' is '{unit}', not one of {', '.join(MILLIMETRES)}")
    points = np.stack([values[:, :3] * MILLIMETRES[units[name]] for name, values in markers.items()], axis=1)
    labels = tuple("" if _NAMELESS.fullmatch(name) else bare_label(name) for name in markers)
    rate = _rate(np.asarray(series.time)) if rate is None else rate
    return Recording(points, labels, rate, next(iter(units.values())))


def to_time_series(recording: Recording) -> Any:
    """What `Recording.to_kineticstoolkit` returns."""
    toolkit = optional("kineticstoolkit", "to_kineticstoolkit")
    series = toolkit.TimeSeries()
    series.time = np.arange(recording.num_frames) / recording.rate
    names = distinct(recording.labels)
    series.data_info = {name: {"Unit": UNIT} for name in names}  # as a whole: what newer versions give is a copy
    for column, name in enumerate(names):
        place = recording.points[:, column] / MILLIMETRES[UNIT]
        series.data[name] = np.column_stack([place, np.where(recording.present[:, column], 1.0, np.nan)])
    return series


def _rate(time: np.ndarray) -> float:
    """Frames a second of evenly spaced times."""
    if len(time) < 2:
        raise ValueError("one frame tells no rate; give from_kineticstoolkit(series, rate=...)")
    mean = (time[-1] - time[0]) / (len(time) - 1)
    if not (np.abs(np.diff(time) - mean) <= _UNEVEN * abs(mean)).all() or not mean > 0:
        raise ValueError("its times are not evenly spaced; resample it, or give from_kineticstoolkit(series, rate=...)")
    return round(float(1 / mean), 6)
