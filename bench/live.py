"""Is a capture labelled faster than it runs, and as it would be afterwards?

    python bench/live.py [--seconds 20] [--rate 120] [--gaps 0.02] [--delay 2] [--block 12] [--quick]

A person in 49 markers with eleven ghosts is pushed in blocks on one core (where the system can pin a process). Printed
are the processor's seconds for each second of capture, the longest that one block took, and how many points have the
labels that the whole recording gets afterwards. Compiling is not counted.
"""

import argparse
import os
import time
from collections.abc import Iterator

import numpy as np
from _rows import Row, show

from dshpm_jax import Labeller, Recording, SubjectModel, label
from dshpm_jax._types import NO_MATCH
from dshpm_jax.synthesis import add_ghosts, open_gaps, person, scramble

MARKERS, GHOSTS = 49, 11


def rows(
    quick: bool, seconds: float = 20.0, rate: float = 120.0, gaps: float = 0.02, delay: float = 2.0, block: int = 12
) -> Iterator[Row]:
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    seconds = min(seconds, 10.0) if quick else seconds
    rng = np.random.default_rng(0)
    model = SubjectModel.from_recordings([person(MARKERS, "freeform", 1200, rate, seed=1).recording])
    take = person(MARKERS, "walking", round(seconds * rate), rate, seed=2).recording
    recording, truth = scramble(add_ghosts(open_gaps(take, gaps, rng), GHOSTS / MARKERS, rng), rng)
    push_all(recording, model, delay, block)  # compiles
    live, spent, longest = push_all(recording, model, delay, block)
    afterwards = label(recording, model).identities
    seen, right = recording.present, truth.numbered_by(model.markers)
    case = f"{seen.sum(1).mean():.0f} points at {rate:g} Hz, {block} frames a block"
    yield Row(case, "core seconds a second of capture", spent / seconds, at_most=1.0)
    yield Row(case, "longest block (s)", longest)
    yield Row(case, "labels as afterwards (%)", 100 * (live == afterwards)[seen].mean())
    for name, found in (("live", live), ("afterwards", afterwards)):
        yield Row(case, f"right, {name} (%)", 100 * (found == right)[seen].mean())
        yield Row(case, f"wrong, {name} (%)", 100 * ((found != right) & (found != NO_MATCH))[seen].mean())


def push_all(recording: Recording, model: SubjectModel, delay: float, block: int) -> tuple[np.ndarray, float, float]:
    """All identities, the processor's seconds, and the seconds that the longest block took."""
    labeller = Labeller(model, recording.rate, delay)
    begin, parts, longest = time.process_time(), [], 0.0
    for first in range(0, recording.num_frames, block):
        pushed = time.perf_counter()
        parts.append(labeller.push(recording.points[first : first + block]))
        longest = max(longest, time.perf_counter() - pushed)
    parts.append(labeller.finish())
    return np.concatenate([part.identities for part in parts]), time.process_time() - begin, longest


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--rate", type=float, default=120.0)
    parser.add_argument("--gaps", type=float, default=0.02, help="share of the points that are missing")
    parser.add_argument("--delay", type=float, default=2.0, help="seconds")
    parser.add_argument("--block", type=int, default=12, help="frames pushed at a time")
    parser.add_argument("--quick", action="store_true", help="ten seconds of capture")
    show(rows(**vars(parser.parse_args())))


if __name__ == "__main__":
    main()
