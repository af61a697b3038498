"""Identification of distorted sequences by the static, the dynamic and the default method (section 5.2.1, Fig. 8)."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from dshpm_jax._control.targets import mean_edge
from dshpm_jax._experiments.figures import COLOURS, panels, save
from dshpm_jax._experiments.records import Records, write_rows
from dshpm_jax._experiments.statistics import precision_of, rate_of, times_of
from dshpm_jax._experiments.subjects import Subject, piece
from dshpm_jax._experiments.trials import NAMES, Case, ExperimentPlan, Point, generator, spoilt
from dshpm_jax._geometry import pair_distances
from dshpm_jax._model import SubjectModel
from dshpm_jax._settings import Method
from dshpm_jax.synthesis import distort

LEVELS = (0.0, 0.04, 0.08, 0.12, 0.16, 0.2)  # up to the largest distortion ratio of section 5.1.1
METHODS: tuple[Method, ...] = ("static", "paper", "full")
KIND = "distortion"
HEADER = ("markers", "level", "method", "trials", "rate", "low", "high", "precision", "seconds", "alone")


def plan(subjects: Mapping[int, Subject], frames: int, seed: int) -> ExperimentPlan:
    """All levels for each of `subjects`, by their number of markers; pieces of `frames` frames."""

    def case(point: Point, trial: int) -> Case:
        subject, rng = subjects[point.markers], generator(seed, point, trial)
        length = segment_length(subject.model)
        whole = piece(subject.recording, frames, rng)
        return spoilt(distort(whole, point.level, length, rng), subject.model, rng)

    points = [Point(n, KIND, level, method) for n in subjects for method in METHODS for level in LEVELS]
    return ExperimentPlan(points, case)


def segment_length(model: SubjectModel) -> float:
    """The average segmental length (mm).

    Our reading: the mean distance of two markers of a segment, averaged over the segments; the scale of Eq. 4.
    """
    return float(np.mean([mean_edge(pair_distances(s.shape)) for s in model.segments if len(s.markers) > 1]))


def write_table(plan: ExperimentPlan, records: Records, path: Path) -> None:
    """A row for each point: rate by points with its 95 % interval, precision, seconds side by side and alone."""
    rows = []
    for point in plan.points:
        found = records.of(point)
        row = (*rate_of(found), precision_of(found), *times_of(found))
        rows.append((point.markers, point.level, NAMES[point.method], len(found), *row))
    write_rows(path, HEADER, rows)


def draw(plan: ExperimentPlan, records: Records, path: Path) -> None:
    """Rate against distortion level, a panel for each number of markers."""
    densities = list(dict.fromkeys(point.markers for point in plan.points))
    figure, axes = panels(len(densities))
    for markers, ax in zip(densities, axes, strict=True):
        for method in METHODS:
            means = [rate_of(records.of(Point(markers, KIND, level, method))) for level in LEVELS]
            rates = 100 * np.array(means)
            ax.fill_between(LEVELS, rates[:, 1], rates[:, 2], color=COLOURS[method], alpha=0.18, linewidth=0)
            ax.plot(LEVELS, rates[:, 0], "o-", color=COLOURS[method], label=NAMES[method])
        ax.set(title=f"{markers} markers", xlabel="distortion level", ylim=(0, 103), xlim=(-0.005, LEVELS[-1] + 0.005))
    axes[0].set_ylabel("identification rate (% of points)")
    axes[0].legend(loc="lower left")
    save(figure, path)
