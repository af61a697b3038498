"""Identification by marker protocol and activity, beside the figures of the paper (section 5.1.3, Table 1).

The paper says how many points were missing or extra, and how many trajectories there were; both together say how
broken its recordings were. Every row is run so, and once more with far more and shorter gaps and ghosts.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from dshpm_jax._experiments.figures import COLOURS, INK, panels, save
from dshpm_jax._experiments.records import Records, write_rows
from dshpm_jax._experiments.statistics import Mean, mean_of, precision_of
from dshpm_jax._experiments.subjects import RATE, Subject, piece, synthetic
from dshpm_jax._experiments.trials import NAMES, Case, ExperimentPlan, Point, TrialResult, generator, spoilt
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Method
from dshpm_jax.synthesis import add_ghosts, open_gaps

PROTOCOLS = (27, 34, 49)
ACTIVITIES = {"walking": 1, "running": 1, "freeform": 2}  # and how many times as long as the first their takes are
METHODS: tuple[Method, ...] = ("paper", "full")
LEAST, MOST = 0.10, 0.15  # of the points: "average missing and extra data is about 10-15%"
AS_PUBLISHED, BROKEN = 0.0, 1.0
"""Levels of a row. As published: so many points missing and extra together, in as many gaps and ghosts as the paper's
row has trajectories beyond its markers. Broken: so many missing, and so many again extra, in pieces of up to a second
as in section 5.2.2, which makes several times as many trajectories."""
BREAKS = {AS_PUBLISHED: "as published", BROKEN: "of up to 1 s"}
PAPER_FRAMES = 600  # of its shorter takes
SIZE = (3.8, 4.2)  # inches


class Published(NamedTuple):
    """A row of the paper's Table 1; its speed is that of Matlab on a Pentium IV with 512 MB."""

    trajectories: int
    rate: float
    frames_per_second: int


PUBLISHED = {
    (27, "walking"): Published(32, 0.96, 300),
    (27, "running"): Published(40, 0.95, 270),
    (27, "freeform"): Published(93, 0.94, 220),
    (34, "walking"): Published(45, 0.98, 380),
    (34, "running"): Published(54, 0.97, 320),
    (34, "freeform"): Published(106, 0.94, 250),
    (49, "walking"): Published(56, 0.96, 280),
    (49, "running"): Published(65, 0.94, 220),
    (49, "freeform"): Published(128, 0.91, 130),
}
HEADER = ("markers", "activity", "breaks", "frames", "method", "trials")
OWN = ("trajectories", "rate", "low", "high", "precision", "frames_per_second", "frames_per_second_alone")
OF_THE_PAPER = ("paper_trajectories", "paper_rate", "paper_frames_per_second")


def plan(frames: int, seed: int) -> ExperimentPlan:
    """All protocols and activities; every trial is another synthetic person with a model of their own."""

    def subject(point: Point, trial: int) -> Subject:
        return synthetic(point.markers, point.kind, ACTIVITIES[point.kind] * frames, trial + 1, seed)

    rows = [(*kind, level) for level in BREAKS for kind in PUBLISHED if kind[0] in PROTOCOLS]
    return _plan(rows, subject, max(ACTIVITIES.values()) * frames, seed)


def plan_of(subject: Subject, name: str, frames: int, seed: int) -> ExperimentPlan:
    """A single row: pieces of one recording, broken as no row of the paper says."""
    return _plan([(subject.recording.points.shape[1], name, BROKEN)], lambda *_: subject, frames, seed)


def _plan(
    rows: Sequence[tuple[int, str, float]], subject: Callable[[Point, int], Subject], frames: int, seed: int
) -> ExperimentPlan:
    def case(point: Point, trial: int) -> Case:
        who, rng = subject(point, trial), generator(seed, point, trial)
        return spoilt(_worn(piece(who.recording, frames, rng), point, rng), who.model, rng)

    return ExperimentPlan([Point(*row, method) for row in rows for method in METHODS], case)


def _worn(whole: Recording, point: Point, rng: np.random.Generator) -> Recording:
    """The recording with the gaps and ghosts of its row."""
    missing, extra = rng.uniform(LEAST, MOST, 2)
    if point.level == BROKEN:
        return add_ghosts(open_gaps(whole, missing, rng), extra, rng)
    missing, extra = missing / 2, extra / 2
    longest = 2 * (missing + extra) * whole.points.shape[1] / _breaks_a_second(point)  # twice the mean
    return add_ghosts(open_gaps(whole, missing, rng, longest), extra, rng, longest_seconds=longest)


def _breaks_a_second(point: Point) -> float:
    """Gaps and ghosts that begin in a second of the paper's row: each makes one more trajectory."""
    seconds = PAPER_FRAMES * ACTIVITIES[point.kind] / RATE
    return (PUBLISHED[point.markers, point.kind].trajectories - point.markers) / seconds


def write_table(plan: ExperimentPlan, records: Records, path: Path) -> None:
    """A row for each protocol, activity, way of breaking and method, with the paper's own figures behind."""
    rows = []
    for point in plan.points:
        found = records.of(point)
        frames = float(np.mean([one.frames for one in found]))
        trajectories = float(np.mean([one.trajectories for one in found]))
        own = (trajectories, *trajectory_rate_of(found), precision_of(found), *speed_of(found))
        paper = PUBLISHED.get((point.markers, point.kind), ("", "", ""))
        what = (point.markers, point.kind, BREAKS[point.level], frames, NAMES[point.method], len(found))
        rows.append((*what, *own, *paper))
    write_rows(path, (*HEADER, *OWN, *OF_THE_PAPER), rows)


def trajectory_rate_of(outcomes: Sequence[TrialResult]) -> Mean:
    """The rate of trajectories over trials."""
    return mean_of([one.trajectory_rate for one in outcomes], (0.0, 1.0))


def speed_of(outcomes: Sequence[TrialResult]) -> tuple[float, float]:
    """Frames a second: of all trials side by side, and of the first one alone."""
    together = sum(one.frames for one in outcomes) / sum(one.seconds for one in outcomes)
    return together, outcomes[0].frames / outcomes[0].alone


def draw(plan: ExperimentPlan, records: Records, path: Path) -> None:
    """Rates and frames a second of every row, the paper's beside ours; hollow where recordings are more broken."""
    kinds = list(dict.fromkeys((point.markers, point.kind) for point in plan.points))
    figure, (rates, speeds) = panels(2, SIZE)
    heights = np.arange(len(kinds))[::-1]
    published = [PUBLISHED.get(kind) for kind in kinds]
    _published(rates, heights, [p and 100 * p.rate for p in published])
    _published(speeds, heights, [p and p.frames_per_second for p in published])
    levels = sorted({point.level for point in plan.points})
    series: list[tuple[float, Method]] = [(level, method) for level in levels for method in METHODS]
    for (level, method), lift in zip(series, np.linspace(0.27, -0.27, len(series)), strict=True):
        found = [records.of(Point(*kind, level, method)) for kind in kinds]
        means = 100 * np.array([trajectory_rate_of(some) for some in found])
        error = np.nan_to_num(np.abs(means[:, 1:] - means[:, :1]).T)
        hollow = {"markerfacecolor": "white"} if level == BROKEN else {}
        look = {"color": COLOURS[method], "label": f"{NAMES[method]}, gaps {BREAKS[level]}", **hollow}
        rates.errorbar(means[:, 0], heights + lift, xerr=error, fmt="o", elinewidth=1, capsize=1.5, **look)
        speeds.plot([speed_of(some)[0] for some in found], heights + lift, "o", **look)
    rates.set_yticks(heights, [f"{activity}, {markers} markers" for markers, activity in kinds])
    rates.set_xlabel("identification rate (% of trajectories)")
    speeds.set_xlabel("frames per second")
    speeds.set_xscale("log")
    low, high = speeds.get_xlim()
    speeds.set_xlim(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))
    figure.legend(*speeds.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    save(figure, path)


def _published(ax: Any, heights: np.ndarray, values: Sequence[Any]) -> None:
    shown = [(value, height) for value, height in zip(values, heights, strict=True) if value]
    if shown:
        ax.plot(*zip(*shown, strict=True), "D", color="white", markeredgecolor=INK, label="paper", zorder=3)
