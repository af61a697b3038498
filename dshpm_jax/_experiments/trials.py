"""Trials: many spoilt sequences labelled side by side, each scored against its truth."""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Int

from dshpm_jax._driver import Driver
from dshpm_jax._geometry import evenly_spaced
from dshpm_jax._label import label_many
from dshpm_jax._labelling import Labelling
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Method, Settings
from dshpm_jax.evaluation import point_identification_rate, precision_recall_f1, trajectory_identification_rate
from dshpm_jax.synthesis import scramble

SIDE_BY_SIDE = 128  # trials labelled at the same time, before their results are kept
STATIC_FRAMES = 20  # of a trial that the static scheme is asked; it judges each frame alone, so they stand for all
NAMES = {"static": "static", "paper": "dynamic", "full": "default"}  # of the methods, as the figures call them


class Point(NamedTuple):
    """One point of a figure or row of a table: so many markers, spoilt in one way to one degree, for one method."""

    markers: int
    kind: str
    level: float
    method: Method


class Case(NamedTuple):
    """What one trial labels.

    Attributes:
        recording: without names.
        truth: places in the model's markers, `NO_MATCH` for ghosts.
        model: of the subject.
    """

    recording: Recording
    truth: Int[np.ndarray, "frames points"]
    model: SubjectModel


class TrialResult(NamedTuple):
    """What one trial gave.

    Attributes:
        rate: share of the markers' points that got their label (section 5.2.1).
        trajectory_rate: share of the markers' trajectories that are identified (section 5.1.3).
        precision: share of the labels that are right, NaN without any.
        trajectories: in the recording, those of ghosts included.
        fits: rigid fits that labelling took (section 5.2.3).
        frames: of the recording.
        seconds: its share of the time that the trials labelled beside it, in the same process, took.
        alone: seconds that labelling it alone takes; measured for the first trial of a point, else NaN.
    """

    rate: float
    trajectory_rate: float
    precision: float
    trajectories: int
    fits: int
    frames: int
    seconds: float
    alone: float


@dataclass(frozen=True, eq=False)
class ExperimentPlan:
    """An experiment: its points, and what trial number k of a point is.

    The trials of two points that differ in the method alone are the same.
    """

    points: Sequence[Point]
    case: Callable[[Point, int], Case]


def spoilt(recording: Recording, model: SubjectModel, rng: np.random.Generator) -> Case:
    """A trial of a recording that has been spoilt already."""
    bare, truth = scramble(recording, rng)
    return Case(bare, truth.numbered_by(model.markers), model)


def generator(seed: int, point: Point, trial: int) -> np.random.Generator:
    """The numbers of one trial: the same for all methods, and however many trials there are."""
    name = [*point.kind.encode(), round(1000 * point.level)]
    return np.random.default_rng([seed, point.markers, trial, *name])


def run_trials(plan: ExperimentPlan, point: Point, trials: range) -> list[TrialResult]:
    """The outcomes of some trials of a point, in their order, all labelled side by side."""
    cases = [_asked(plan.case(point, k), point.method) for k in trials]
    labellings, seconds = _timed(cases, point.method)
    alone = np.full(len(cases), np.nan)
    if trials.start == 0:
        _timed(cases[:1], point.method)  # compiles what only a lone trial needs
        alone[0] = _timed(cases[:1], point.method)[1]
    return [
        _outcome(case, labelling, seconds / len(cases), float(lone))
        for case, labelling, lone in zip(cases, labellings, alone, strict=True)
    ]


def warm_up(plan: ExperimentPlan, points: Iterable[Point]) -> None:
    """Compiles what the first trial of each of `points` needs, so that it is in nobody's time."""
    for point in points:
        _timed([_asked(plan.case(point, 0), point.method)], point.method)


def _timed(cases: Sequence[Case], method: Method) -> tuple[list[Labelling], float]:
    start = time.perf_counter()
    settings, driver = Settings(method=method), Driver(in_flight=SIDE_BY_SIDE)
    found = list(label_many([case.recording for case in cases], [case.model for case in cases], settings, driver))
    return found, time.perf_counter() - start


def _asked(case: Case, method: Method) -> Case:
    """What the method is asked of a case: all of it, or of the static scheme some frames, evenly spread."""
    frames = case.recording.num_frames
    if method != "static" or frames <= STATIC_FRAMES:
        return case
    some = evenly_spaced(frames, STATIC_FRAMES, rounded=True)
    return case._replace(recording=replace(case.recording, points=case.recording.points[some]), truth=case.truth[some])


def _outcome(case: Case, labelling: Labelling, seconds: float, alone: float) -> TrialResult:
    given = labelling.identities
    return TrialResult(
        point_identification_rate(given, case.truth),
        trajectory_identification_rate(given, case.truth),
        precision_recall_f1(given, case.truth).precision,
        len(labelling.trajectories),
        int(labelling.stats["svd_count"]),
        case.recording.num_frames,
        seconds,
        alone,
    )
