"""Is a capture labelled faster than it runs, and as it would be afterwards?

    python bench/live.py [--seconds 20] [--rate 120] [--gaps 0.02] [--delay 2] [--block 12]

A person in 49 markers with eleven ghosts is pushed in blocks on one core (where the system can pin a process). Printed
are the processor's seconds for each second of capture, the longest that one block took, and how many points have the
labels that the whole recording gets afterwards. Compiling is not counted. On one shared CPU core, jax 0.10:

    2400 frames at 120 Hz, 59 points a frame, 12 frames a block
    processor 0.23 s a second of capture, longest block 1.06 s
    as afterwards 100.00%
    live: right 100.00%, wrong 0.000%
    afterwards: right 100.00%, wrong 0.000%
"""

import argparse
import os
import time

import numpy as np

from dshpm_jax import Labeller, Recording, SubjectModel, label
from dshpm_jax.synthesis import add_ghosts, open_gaps, person, scramble

MARKERS, GHOSTS = 49, 11


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--rate", type=float, default=120.0)
    parser.add_argument("--gaps", type=float, default=0.02, help="share of the points that are missing")
    parser.add_argument("--delay", type=float, default=2.0, help="seconds")
    parser.add_argument("--block", type=int, default=12, help="frames pushed at a time")
    arguments = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

    rng = np.random.default_rng(0)
    model = SubjectModel.from_recordings([person(MARKERS, "freeform", 1200, arguments.rate, seed=1).recording])
    frames = round(arguments.seconds * arguments.rate)
    take = person(MARKERS, "walking", frames, arguments.rate, seed=2).recording
    recording, truth = scramble(add_ghosts(open_gaps(take, arguments.gaps, rng), GHOSTS / MARKERS, rng), rng)
    push_all(recording, model, arguments)  # compiles
    live, spent, longest = push_all(recording, model, arguments)
    afterwards = label(recording, model).identities
    seen, right = recording.present, truth.numbered_by(model.markers)
    points = seen.sum(1).mean()
    print(f"{frames} frames at {arguments.rate:g} Hz, {points:.0f} points a frame, {arguments.block} frames a block")
    print(f"processor {spent / arguments.seconds:.2f} s a second of capture, longest block {longest:.2f} s")
    print(f"as afterwards {(live == afterwards)[seen].mean():.2%}")
    for name, found in (("live", live), ("afterwards", afterwards)):
        wrong = ((found != right) & (found != -1))[seen].mean()
        print(f"{name}: right {(found == right)[seen].mean():.2%}, wrong {wrong:.3%}")


def push_all(
    recording: Recording, model: SubjectModel, arguments: argparse.Namespace
) -> tuple[np.ndarray, float, float]:
    """All identities, the processor's seconds, and the seconds that the longest block took."""
    labeller = Labeller(model, arguments.rate, arguments.delay)
    begin, parts, longest = time.process_time(), [], 0.0
    for first in range(0, recording.num_frames, arguments.block):
        pushed = time.perf_counter()
        parts.append(labeller.push(recording.points[first : first + arguments.block]))
        longest = max(longest, time.perf_counter() - pushed)
    parts.append(labeller.finish())
    return np.concatenate([part.identities for part in parts]), time.process_time() - begin, longest


if __name__ == "__main__":
    main()
