"""Identification of sequences with points missing, or with extra ones (section 5.2.2, Fig. 9)."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dshpm_jax._experiments.figures import COLOURS, INK, panels, save
from dshpm_jax._experiments.records import Records, write_rows
from dshpm_jax._experiments.statistics import Mean, precision_of, rate_of, times_of
from dshpm_jax._experiments.subjects import Subject, piece
from dshpm_jax._experiments.trials import NAMES, Case, ExperimentPlan, Point, TrialResult, generator, spoilt
from dshpm_jax._settings import Method
from dshpm_jax.synthesis import add_ghosts, open_gaps

FRACTIONS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
METHODS: tuple[Method, ...] = ("paper", "full")
MISSING, EXTRA = "missing", "extra"
SIZE = (4.6, 3.6)  # inches
HEADER = ("markers", "kind", "fraction", "method", "trials")
VALUES = ("trajectories", "rate", "low", "high", "precision", "seconds", "alone")


def plan(subjects: Mapping[int, Subject], frames: int, seed: int) -> ExperimentPlan:
    """All fractions for each of `subjects`, by their number of markers; pieces of `frames` frames."""

    def case(point: Point, trial: int) -> Case:
        subject, rng = subjects[point.markers], generator(seed, point, trial)
        whole = piece(subject.recording, frames, rng)
        spoil = open_gaps if point.kind == MISSING else add_ghosts
        return spoilt(spoil(whole, point.level, rng), subject.model, rng)

    return ExperimentPlan([p for n in subjects for method in METHODS for p in points_of(n, method)], case)


def points_of(markers: int, method: Method) -> list[Point]:
    """The points of one curve, from most missing over none to most extra."""
    missing = [Point(markers, MISSING, f, method) for f in reversed(FRACTIONS)]
    extra = [Point(markers, EXTRA, f, method) for f in FRACTIONS]
    return [*missing, Point(markers, MISSING, 0.0, method), *extra]


def write_table(plan: ExperimentPlan, records: Records, path: Path) -> None:
    """A row for each point: mean number of trajectories, rate by points with its 95 % interval, precision, seconds."""

    def values(found: Sequence[TrialResult]) -> tuple[float, ...]:
        trajectories = float(np.mean([one.trajectories for one in found]))
        return trajectories, *rate_of(found), precision_of(found), *times_of(found)

    write_rows(path, (*HEADER, *VALUES), rows_of(plan, records, values))


def rows_of(plan: ExperimentPlan, records: Records, values: Callable[[Sequence[TrialResult]], tuple]) -> list[tuple]:
    """A row for each point: which it is, how many trials it has, and `values` of its outcomes."""
    rows = []
    for point in plan.points:
        found = records.of(point)
        rows.append((point.markers, point.kind, point.level, NAMES[point.method], len(found), *values(found)))
    return rows


def draw(plan: ExperimentPlan, records: Records, path: Path) -> None:
    """Rate against the fraction that is missing or extra, and the number of trajectories on the top axis."""
    figure, ax = curves(plan, records, rate_of, 100.0)
    ax.set(ylabel="identification rate (% of points)", ylim=(0, 103))
    save(figure, path)


def curves(
    plan: ExperimentPlan, records: Records, value: Callable[[Sequence[TrialResult]], Mean], factor: float = 1.0
) -> tuple[Any, Any]:
    """A curve for each method and number of markers, missing to the left of zero and extra to the right."""
    densities = sorted({point.markers for point in plan.points})
    figure, (ax,) = panels(1, SIZE)
    for method in METHODS:
        for markers in densities:
            along = points_of(markers, method)
            means = factor * np.array([value(records.of(point)) for point in along])
            x = [_signed(point) for point in along]
            dense = len(densities) > 1 and markers == densities[-1]
            label = f"{NAMES[method]}, {markers} markers"
            ax.fill_between(x, means[:, 1], means[:, 2], color=COLOURS[method], alpha=0.15, linewidth=0)
            ax.plot(x, means[:, 0], "s--" if dense else "o-", color=COLOURS[method], label=label)
    ax.axvline(0, color=INK, linewidth=0.8)
    ticks = [_signed(point) for point in points_of(densities[0], METHODS[0])]
    ax.set_xticks(ticks, [f"{abs(t):.0f}" for t in ticks])
    ax.set_xlabel(r"missing $\leftarrow$    fraction of corrupted data (%)    $\rightarrow$ extra")
    _trajectories_on_top(ax, records, densities, ticks)
    figure.legend(loc="outside lower center", ncols=len(METHODS), handlelength=3)
    return figure, ax


def _signed(point: Point) -> float:
    """Where a point stands on the axis: percent, missing below zero."""
    return 100 * point.level * (-1 if point.kind == MISSING else 1)


def _trajectories_on_top(ax: Any, records: Records, densities: Sequence[int], ticks: Sequence[float]) -> None:
    """The mean number of trajectories at each fraction, a line for each number of markers."""
    top = ax.secondary_xaxis("top")
    columns = []
    for markers in densities:
        found = [records.of(point) for point in points_of(markers, METHODS[0])]
        columns.append([f"{np.mean([one.trajectories for one in some]):.0f}" for some in found])
    top.set_xticks(ticks, ["\n".join(numbers) for numbers in zip(*columns, strict=True)])
    top.tick_params(labelsize=7, length=2)
    top.set_xlabel(f"number of trajectories, for {' and, below, '.join(map(str, densities))} markers")
