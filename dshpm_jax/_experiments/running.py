"""Runs one experiment: trials, tables, figures, and what it says meanwhile."""

import hashlib
import sys
from pathlib import Path
from typing import Any, NamedTuple

from dshpm_jax import io
from dshpm_jax._experiments import complexity, corruption, distortion, table1
from dshpm_jax._experiments.figures import style
from dshpm_jax._experiments.processes import Batch, run_apart
from dshpm_jax._experiments.records import Records, refuse_foreign
from dshpm_jax._experiments.statistics import rate_of, times_of
from dshpm_jax._experiments.subjects import Subject, recorded, synthetic
from dshpm_jax._experiments.trials import NAMES, SIDE_BY_SIDE, ExperimentPlan, Point, run_trials, warm_up
from dshpm_jax._messages import UsageError

DENSITIES = (30, 50)  # markers, section 5.2
TRIALS = {"table1": 20, "distortion": 500, "corruption": 500, "complexity": 500}
SHARED = {"complexity": "corruption"}  # whose trials an experiment takes


class ExperimentOrder(NamedTuple):
    """What was asked for: which experiment, where to, and on what; `None` stands for the usual."""

    name: str
    out: Path | None = None
    trials: int | None = None
    frames: int = 600
    recording: Path | None = None
    model: Path | None = None
    seed: int = 2008
    workers: int = 1


def run(order: ExperimentOrder) -> int:
    """Runs the trials that are not there yet, writes tables and figures; gives the exit status.

    Raises:
        UsageError: an order that makes no sense.
    """
    trials = TRIALS[order.name] if order.trials is None else order.trials
    if trials < 1 or order.frames < 1:
        raise UsageError("an experiment needs at least one trial of one frame; give larger --trials or --frames")
    if order.seed < 0:
        raise UsageError("--seed: random numbers begin with one that is not negative")
    if order.workers < 1:
        raise UsageError("--workers: an experiment needs at least one process")
    if (order.recording is None) != (order.model is None):
        raise UsageError("--recording and --model go together: a labelled recording and the model of its subject")
    folder = Path(f"dshpm-{order.name}") if order.out is None else order.out
    plan = _plan(order)
    trials_of = SHARED.get(order.name, order.name)
    refuse_foreign(folder, order.name, trials_of)
    records = Records(folder, trials_of, _setup(order))
    _run_trials(order, plan, records, trials)
    return _report(order.name, plan, records, folder)


def _plan(order: ExperimentOrder) -> ExperimentPlan:
    """What was asked for."""
    subject = _recorded(order)
    if order.name == "table1":
        if subject and order.recording:
            return table1.plan_of(subject, order.recording.stem, order.frames, order.seed)
        return table1.plan(order.frames, order.seed)
    if subject:
        subjects = {subject.recording.points.shape[1]: subject}
    else:
        subjects = {n: synthetic(n, "walking", order.frames, 0, order.seed) for n in DENSITIES}
    return _module(order.name).plan(subjects, order.frames, order.seed)


def _recorded(order: ExperimentOrder) -> Subject | None:
    if order.recording is None or order.model is None:
        return None
    try:
        return recorded(order.recording, order.model)
    except io.ReadError as error:
        raise UsageError(str(error)) from None


def _module(name: str) -> Any:
    return {"table1": table1, "distortion": distortion, "corruption": corruption, "complexity": complexity}[name]


def _setup(order: ExperimentOrder) -> dict[str, Any]:
    """What the outcomes depend on."""
    files = {"recording": order.recording, "model": order.model}
    return {"seed": order.seed, "frames": order.frames, **{k: f and _hash(f) for k, f in files.items()}}


def _hash(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _run_trials(order: ExperimentOrder, plan: ExperimentPlan, records: Records, trials: int) -> None:
    lacking = [point for point in plan.points if len(records.of(point)) < trials]
    batches = [
        Batch(point, range(first, min(first + SIDE_BY_SIDE, trials)))
        for point in lacking
        for first in range(len(records.of(point)), trials, SIDE_BY_SIDE)
    ]
    if order.workers == 1:
        warm_up(plan, {(p.markers, p.method): p for p in lacking}.values())
        found = (run_trials(plan, *batch) for batch in batches)
    else:
        found = run_apart(_plan, order, batches, order.workers)
    for batch, outcomes in zip(batches, found, strict=True):
        records.add(batch.point, outcomes)
        if batch.trials.stop == trials:
            print(_line(batch.point, records), flush=True)


def _line(point: Point, records: Records) -> str:
    found = records.of(point)
    rate, (seconds, alone) = rate_of(found), times_of(found)
    what = f"{point.markers} markers, {point.kind}" + (f" {point.level:g}" if point.level else "")
    return (
        f"{what}, {NAMES[point.method]}: {len(found)} trials, {rate.mean:.1%} of the points identified "
        f"({rate.low:.1%} to {rate.high:.1%}), {1000 * seconds:.0f} ms a trial, {1000 * alone:.0f} ms alone"
    )


def _report(name: str, plan: ExperimentPlan, records: Records, folder: Path) -> int:
    module = _module(name)
    module.write_table(plan, records, folder / f"{name}.csv")
    written = f"{name}.csv"
    try:
        with style():
            module.draw(plan, records, folder / f"{name}.png")
        written += f", {name}.png, {name}.pdf"
    except ModuleNotFoundError as missing:
        print(missing, file=sys.stderr)
    print(f"in {folder}: {written}")
    return 0
