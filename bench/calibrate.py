"""Fits the confidences, leaving out one data set at a time.

    python bench/calibrate.py WORK [--only REGEX] [--sets CASES.toml ...] [--rescaled REGEX] [--no-findings]

WORK is the folder of an evaluation: `archive` with unlabelled recordings below folders with a `model.json`, and an .npz
with the truth of each. The recordings are labelled in this process. Groups whose data are in one folder are one data
set; `--sets` says which, else the name of the group without the number of markers behind it. With the groups that
`--rescaled` names, the model is another subject's and rescaled. Findings of `check` are counted on the labelled
recordings themselves, in which markers are exchanged and points moved for some frames.

Prints a row for each data set: the numbers that all others lead to, and how far they hold on it, above the numbers of
today. Writes the numbers that all data sets together lead to, and what they were fitted on, to
`bench/results/calibration.json`.
"""

import argparse
import json
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from _calibration import (
    BINS,
    Findings,
    Labels,
    Numbers,
    chance,
    finding_chance,
    fitted,
    left_out,
    log_loss,
    reliability,
)
from _cases import Case, cases
from _machine import description
from _planting import judged_findings
from _truth import judged_trajectories

from dshpm_jax import Settings, SubjectModel
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._control.full.confidence import WEIGHTS, confidence_features
from dshpm_jax._control.full.objective import model_fit
from dshpm_jax._control.full.search import solve
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._control.uses.population import rescaled
from dshpm_jax._driver import Driver
from dshpm_jax._pretracking import pretrack
from dshpm_jax._requests import Control
from dshpm_jax._trajectories import Trajectories

RESULTS = Path(__file__).parent / "results" / "calibration.json"
AT_ONCE = 16  # recordings that are labelled side by side
FIELDS = ("poor_fit_below", "poor_fit_share", "rescaled_share")  # of `Tuning`, besides the weights
FINDING_PER_LLR = 0.5  # a probability for each nat of a finding, as `check` had it, by hand


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("work", type=Path)
    parser.add_argument("--only", default="", help="paths below WORK/archive that count, a regular expression")
    parser.add_argument("--sets", type=Path, nargs="*", default=[], help="case lists that say where a group's data are")
    parser.add_argument("--rescaled", default="^$", help="groups with another subject's model, a regular expression")
    parser.add_argument("--no-findings", action="store_true", help="leave `check` out")
    parser.add_argument("-o", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    cache_programs()
    every = cases(arguments.work, arguments.only, arguments.sets)
    labels = labels_of(every, arguments.rescaled)
    findings = findings_of([] if arguments.no_findings else every)
    now, after = numbers_of(TUNING), fitted(labels, findings, numbers_of(TUNING))
    rows = list(judged(labels, findings, now))
    show(rows)
    arguments.o.write_text(json.dumps(result(labels, findings, now, after, rows), indent=1) + "\n")


def numbers_of(tuning: Tuning) -> Numbers:
    """The numbers of today."""
    weights = tuple(getattr(tuning, name) for name in WEIGHTS)
    return Numbers(weights, **{name: getattr(tuning, name) for name in FIELDS}, finding_per_llr=FINDING_PER_LLR)


def labels_of(every: Sequence[Case], rescaled: str) -> Labels:
    """Every labelled trajectory of the cases that can be judged."""
    rows = []
    for is_rescaled in (False, True):
        some = [case for case in every if bool(re.search(rescaled, case.name.partition("/")[0])) == is_rescaled]
        for first in range(0, len(some), AT_ONCE):
            rows += list(_labelled(some[first : first + AT_ONCE], is_rescaled))
            print(f"{len(rows)} recordings of {len(every)} labelled", flush=True)
    return gathered(rows)


def gathered(rows: Sequence[tuple]) -> Labels:
    """Data set, recording, features, right, fit and whether rescaled, of the labels of each recording, as one."""
    size = [len(row[3]) for row in rows]
    data_set, recording, fit, rescaled = (np.repeat([row[k] for row in rows], size) for k in (0, 1, 4, 5))
    number = np.unique(recording, return_inverse=True)[1]
    features, right = (np.concatenate([row[k] for row in rows]) for k in (2, 3))
    return Labels(data_set, number, features, right, fit, rescaled)


def _labelled(some: Sequence[Case], is_rescaled: bool) -> Iterator[tuple]:
    """The columns of `Labels` for each case."""
    inputs = [case.read() for case in some]
    controls = [judged_labels(pretrack(recording), model, is_rescaled) for recording, model, _ in inputs]
    for case, found, (*_, truth) in zip(some, Driver().run(controls), inputs, strict=True):
        problem, identity, features, fit = found
        which, right = judged_trajectories(problem.trajectories, identity, problem.model, truth)
        yield case.data_set, case.name, features[which], right, fit, is_rescaled


def judged_labels(tracks: Trajectories, model: SubjectModel, is_rescaled: bool) -> Control[tuple]:
    """A recording labelled, nothing withheld: the problem, its labels, their features, how well the model fits."""
    settings = Settings()
    if is_rescaled:
        model = yield from rescaled(tracks, model, settings, TUNING)
    problem, solution = yield from solve(LabellingProblem(tracks, model, settings))
    features = yield from confidence_features(problem, solution)
    return problem, solution.identity, features, model_fit(problem, solution)


def findings_of(every: Sequence[Case]) -> Findings:
    """What `check` says of the cases' labelled recordings with planted errors."""
    sets, nats, right = [], [], []
    for k, case in enumerate(every):
        _, model, truth = case.read()
        for evidence, is_right in judged_findings(truth, model, np.random.default_rng(k)):
            sets.append(case.data_set)
            nats.append(evidence)
            right.append(is_right)
    return Findings(np.array(sets, str), np.array(nats, float), np.array(right, bool))


def named(numbers: Numbers) -> dict[str, float]:
    """The numbers by the fields of `Tuning`, and that of `check`."""
    rest = numbers._asdict()
    return dict(zip(WEIGHTS, rest.pop("weights"), strict=True)) | rest


def judged(labels: Labels, findings: Findings, now: Numbers) -> Iterator[dict[str, Any]]:
    """A row for each data set: what the others lead to, and how far it holds on it beside today's numbers."""
    for name, numbers in left_out(labels, findings, now):
        here, said = labels.where(labels.data_set == name), findings.where(findings.data_set == name)
        yield {
            "set": name,
            "recordings": len(np.unique(here.recording)),
            "trajectories": len(here),
            "right": int(here.right.sum()),
            "findings": len(said),
            "findings_right": int(said.right.sum()),
            "numbers": named(numbers),
            "held": _held(here, said, numbers),
            "held_now": _held(here, said, now),
        }


def _held(labels: Labels, findings: Findings, numbers: Numbers) -> dict[str, Any]:
    p = chance(numbers, labels)
    return {
        "log_loss": log_loss(p, labels.right),
        "bins": reliability(p, labels.right),
        "findings_log_loss": log_loss(finding_chance(numbers, findings), findings.right),
    }


def show(rows: Sequence[dict[str, Any]]) -> None:
    """The table: for each data set the numbers of the others, then how these and today's hold on it."""
    heads = (*("base", "/nat", "/decade", "/own", "/margin", "/swap", "fit <", "share", "rescaled", "check"), "")
    bins = " ".join(f"{f'{low:g}-{high:g}' if high < 1 else f'>= {low:g}':>14}" for low, high in BINS)
    counts = ("labels", "wrong", "findings", "wrong")
    print(f"{'left out':24} {_cells(counts)} {_cells(heads)} {bins} {'log loss':>9} {'of check':>9}")
    for row in rows:
        wrong = row["trajectories"] - row["right"], row["findings"] - row["findings_right"]
        told = _cells((row["trajectories"], wrong[0], row["findings"], wrong[1]))
        numbers = _cells((*(f"{x:.3f}" for x in row["numbers"].values()), "fitted"))
        print(f"{row['set'][:24]:24} {told} {numbers} {_line(row['held'])}")
        print(f"{'':24} {'':{len(told)}} {'today':>{len(numbers)}} {_line(row['held_now'])}")


def _cells(cells: Sequence[Any]) -> str:
    return " ".join(f"{cell:>8}" for cell in cells)


def _line(held: dict[str, Any]) -> str:
    bins = " ".join(f"{count:6} {share:7.4f}" for count, share in held["bins"])
    return f"{bins} {held['log_loss']:9.4f} {held['findings_log_loss']:9.4f}"


def result(labels: Labels, findings: Findings, now: Numbers, after: Numbers, rows: list) -> dict[str, Any]:
    """What is kept: the numbers, what they were fitted on, and how far they hold where they were not."""
    before, fitted_now = named(now), named(after)
    return {
        "machine": description(),
        "numbers": {k: {"today": before[k], "fitted": round(fitted_now[k], 4)} for k in before},
        "fitted_on": {
            "trajectories": dict(Counter(labels.data_set.tolist())),
            "findings": dict(Counter(findings.data_set.tolist())),
            "wrong": int((~labels.right).sum()),
        },
        "left_out": rows,
    }


if __name__ == "__main__":
    main()
