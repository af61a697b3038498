"""How many answers of a person does a recording take, and what is solving again around each of them worth?

    python bench/corrections.py WORK [--only REGEX] [--answers 30] [--json OUT.json]

WORK is the folder of an evaluation: `archive` with unlabelled recordings below folders with a `model.json`, and an .npz
with the truth of each. A simulated person is asked about one trajectory after the other, and gives the right answer:
its marker, or none, frame by frame where it mixes two. Asked is what the report calls a doubt, as long as there is one,
then all others; of these what has most at stake: points times the probability that what is said of them is wrong.

Prints a row for each recording and way, with F1 after 0, 1, 3, 10, 30 answers and the answers that it took to .9995:

- again: everything around an answer is solved again (`correct`), and the next question comes from what that gives;
- alone: an answer changes nothing but the labels of its points, and takes them from others in these frames;
- random: as "again", but what is asked about is any doubt, and then any other trajectory.

"label" is the full method, given the last answers of "again" as known labels. "wait" are the median and the longest
seconds that an answer took.
"""

import argparse
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from _cases import Case, cases
from _machine import description
from _truth import NEAR, counts, places_of

from dshpm_jax import KnownLabel, Labelling, Reason, correct, label
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._control.fixed_labels import FixedLabels, fix
from dshpm_jax._driver import Driver
from dshpm_jax._known import known_points, latest
from dshpm_jax._labelling import WITHHELD
from dshpm_jax._types import NO_MATCH, UNKNOWN
from dshpm_jax.report._doubts import SURE

SHOWN = (0, 1, 3, 10, 30)
ENOUGH = 0.9995
SEED = 0  # of the random order
LEAST_STAKE = 0.01  # points; below it nothing is asked

Truth = dict[str, np.ndarray]
Solver = Callable[[Labelling, Sequence[KnownLabel], Sequence[KnownLabel]], Labelling]
"""Takes the labels before, all that is known, and what of it is new."""


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("work", type=Path, nargs="+")
    parser.add_argument("--only", default="", help="paths below WORK/archive that count, a regular expression")
    parser.add_argument("--answers", type=int, default=max(SHOWN))
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    cache_programs()
    driver, rows = Driver(), []
    print(f"{'recording':44} {'way':7} " + " ".join(f"{f'F1 {n}':>8}" for n in SHOWN) + "  to .9995  wait (s)")
    for work in arguments.work:
        for case in cases(work, arguments.only):
            for row in rows_of(case, driver, arguments.answers):
                rows.append(row)
                show(row)
    if arguments.json:
        arguments.json.write_text(json.dumps({"machine": description(), "rows": rows}, indent=1) + "\n")


def rows_of(case: Case, driver: Driver, answers: int) -> list[dict[str, Any]]:
    """What each way leads to."""
    recording, model, truth = case.read()
    first = label(recording, model, driver=driver)
    right = true_points(first, truth)

    def again(before: Labelling, known: Sequence[KnownLabel], new: Sequence[KnownLabel]) -> Labelling:
        return correct(before, known, driver=driver, new=new)

    ways: dict[str, tuple[Solver, np.random.Generator | None]] = {
        "again": (again, None),
        "alone": (alone, None),
        "random": (again, np.random.default_rng(SEED)),
    }
    rows = []
    for way, (solve, rng) in ways.items():
        f1, seconds, known = session(first, right, truth, solve, rng, answers)
        rows.append({"recording": case.name, "way": way, "f1": f1, "seconds": seconds})
        if way == "again":
            anew = label(recording, model, driver=driver, known=known)
            rows.append({"recording": case.name, "way": "label", "f1": [f1[0], counts(anew, truth).f1], "seconds": []})
    return rows


def session(
    found: Labelling,
    right: np.ndarray,
    truth: Truth,
    solve: Solver,
    rng: np.random.Generator | None,
    answers: int,
) -> tuple[list[float], list[float], tuple[KnownLabel, ...]]:
    """F1 before and after each answer, the seconds that each took, and what is known at the end."""
    f1, seconds, known = [counts(found, truth).f1], [], ()
    while len(seconds) < answers:
        trajectory = next_question(found, right, rng)
        if trajectory is None:
            break
        new = answer(found, right, trajectory)
        known = latest([*known, *new])
        start = time.perf_counter()
        found = solve(found, known, new)
        seconds.append(time.perf_counter() - start)
        f1.append(counts(found, truth).f1)
    return f1, seconds, known


def next_question(found: Labelling, right: np.ndarray, rng: np.random.Generator | None) -> int | None:
    """The doubt with most at stake, or one at random; where there is none, of all trajectories; None at the end."""
    t = found.trajectories
    stake = (t.stop - t.start) * (1.0 - found.confidence)
    stake[[reason == Reason.KNOWN for reason in found.reason]] = 0.0
    judged = right[t.start, t.column[t.start, t.slot]] != UNKNOWN
    stake[~judged] = 0.0
    named = found.identity != NO_MATCH
    doubts = np.where(named, found.confidence < SURE, [reason in WITHHELD for reason in found.reason])
    some = np.flatnonzero(stake > LEAST_STAKE)
    some = some[doubts[some]] if doubts[some].any() else some
    if not len(some):
        return None
    return int(rng.choice(some)) if rng is not None else int(some[np.argmax(stake[some])])


def answer(found: Labelling, right: np.ndarray, trajectory: int) -> list[KnownLabel]:
    """What a trajectory is, by spans of its columns."""
    t = found.trajectories
    frames = np.arange(int(t.start[trajectory]), int(t.stop[trajectory]))
    columns = t.column[frames, t.slot[trajectory]]
    labels = right[frames, columns]
    edges = [0, *(np.flatnonzero((np.diff(columns) != 0) | (np.diff(labels) != 0)) + 1).tolist(), len(frames)]
    spans = []
    for a, b in zip(edges, edges[1:]):
        if labels[a] != UNKNOWN:
            name = None if labels[a] == NO_MATCH else found.model.markers[labels[a]]
            column = found.recording.columns[columns[a]]
            spans.append(KnownLabel(column, int(frames[a]), int(frames[b - 1]) + 1, name))
    return spans


def alone(before: Labelling, known: Sequence[KnownLabel], new: Sequence[KnownLabel]) -> Labelling:
    """The labels with the new ones in their places, and without those that clash with them."""
    points = known_points(before.recording, before.model.markers, known)
    t, given, whole = fix(before.trajectories, points)
    said = given != UNKNOWN
    identity = FixedLabels.of(t, given, before.model.num_markers).on(before.identity[whole])
    reason = tuple(Reason.KNOWN if now else before.reason[j] for now, j in zip(said, whole))
    confidence = np.where(said, 1.0, before.confidence[whole])
    return replace(before, trajectories=t, identity=identity, confidence=confidence, reason=reason, could_be=None)


def true_points(found: Labelling, truth: Truth) -> np.ndarray:
    """The marker that each point is, `NO_MATCH` where it is none, `UNKNOWN` where that cannot be judged."""
    points, places = found.recording.points, places_of(truth)
    markers = list(found.model.markers)
    right = np.full(points.shape[:2], NO_MATCH, np.int32)
    for k, name in enumerate(truth["labels"].tolist()):
        apart = np.linalg.norm(points - places[:, k, None], axis=-1)
        there = np.nan_to_num(apart, nan=np.inf) < NEAR
        right[there] = markers.index(name) if name in markers else NO_MATCH
        right[there & ~truth["judged"][:, k, None]] = UNKNOWN
    return right


def show(row: dict[str, Any]) -> None:
    f1, seconds = row["f1"], row["seconds"]
    enough = next((str(k) for k, value in enumerate(f1) if value >= ENOUGH), "more")
    shown = [f1[0], f1[-1]] if row["way"] == "label" else [f1[min(n, len(f1) - 1)] for n in SHOWN]
    cells = " ".join(f"{value:8.4f}" for value in shown)
    wait = f"{np.median(seconds):.2f} {max(seconds):.2f}" if seconds else ""
    print(f"{row['recording'][:44]:44} {row['way']:7} {cells:44}  {enough:>8}  {wait}", flush=True)


if __name__ == "__main__":
    main()
