"""How fast is our segment matching beside numpy's?

    python bench/matching.py [--runs N]

One segment among the points of a frame, under every pivot hypothesis, alone and sixteen at once: through the driver,
by a plain loop over the hypotheses that survive culling, and by stacks of them with batched `np.linalg.svd`. The first
call (compiling) is timed apart; then they run in turns. Ratios are medians over the runs of one turn's times.
"""

import argparse
from collections import Counter
from collections.abc import Sequence

import jax
import numpy as np
from _numpy_matching import match_in_loop, match_in_stacks
from _timing import paired, seconds

from dshpm_jax._driver import Driver
from dshpm_jax._requests import MatchSegment, SegmentMatches, Target
from dshpm_jax._types import NO_MATCH

PATIENCE = 20.0  # seconds for a row; one that takes longer is run twice only
BODY = np.array([300.0, 300.0, 900.0])  # mm, half the box that the points of a person fill


def ask(markers: int, points: int, rng: np.random.Generator) -> MatchSegment:
    """A segment with a tenth of its markers lost, among points of a person."""
    shape = rng.normal(0, 100, (markers, 3))
    seen = shape[rng.random(markers) >= 0.1] + rng.uniform(-BODY, BODY)
    cloud = np.concatenate([seen, rng.uniform(-BODY, BODY, (points - len(seen), 3))]) + rng.normal(0, 1, (points, 3))
    cloud = rng.permutation(cloud)
    distance = np.linalg.norm(shape[:, None] - shape[None], axis=-1)
    limits = np.full(markers, 5.0), np.full(markers, 10.0)
    need = max(3, int(np.ceil(0.8 * markers)))
    target = Target(0, np.arange(markers), shape, distance, np.maximum(0.1 * distance, 4.0), *limits, need)
    pivot, assumed = (x.ravel() for x in np.meshgrid(np.arange(markers), np.arange(points), indexing="ij"))
    pinned = np.full(markers, NO_MATCH)
    return MatchSegment(target, cloud, np.ones(points, bool), np.ones((points, points), bool), pinned, pivot, assumed)


def through_driver(requests: Sequence[MatchSegment]) -> list[SegmentMatches]:
    def control(request):
        return (yield request)

    return list(Driver().run(control(request) for request in requests))


def shared(ours, theirs) -> tuple[int, int]:
    """How many matches two answers share, and how many there are."""
    rows = [Counter(zip(map(tuple, a.assigned.tolist()), a.accepted.tolist())) for a in (ours, theirs)]
    return (rows[0] & rows[1]).total(), max(row.total() for row in rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=7)
    runs = parser.parse_args().runs
    print(f"{jax.devices()[0]}; medians of up to {runs} runs in turns, milliseconds; first call in seconds")
    heads = ["points", "markers", "flight", "tables", "kernel", "loop", "stacks", "loop/k", "stacks/k", "first", "same"]
    print(" ".join(f"{head:>8}" for head in heads))
    for points in (60, 120):
        for markers in (4, 8, 16):
            for flight in (1, 16):
                requests = [ask(markers, points, np.random.default_rng([points, markers, k])) for k in range(flight)]
                print(" ".join(f"{cell:>8}" for cell in contest(requests, runs)), flush=True)


def contest(requests: Sequence[MatchSegment], runs: int) -> list[str]:
    """One row of the table."""
    first = seconds(lambda: through_driver(requests))
    ours = through_driver(requests)
    loop, stacks = ([match(request) for request in requests] for match in (match_in_loop, match_in_stacks))
    same = np.sum([shared(*pair) for theirs in (loop, stacks) for pair in zip(ours, theirs)], axis=0)
    if same[0] < 0.99 * same[1]:
        raise SystemExit(f"only {same[0]} of {same[1]} matches are the same: these are not the same algorithm")
    contestants = [
        lambda: through_driver(requests),
        lambda: [match_in_loop(request) for request in requests],
        lambda: [match_in_stacks(request) for request in requests],
    ]
    turn = sum(seconds(contestant) for contestant in contestants)
    runs = max(2, min(runs, int(PATIENCE / turn)))
    (kernel, in_loop, in_stacks), (_, loop_ratio, stacks_ratio) = paired(contestants, runs)
    sizes = [len(requests[0].points), len(requests[0].target.markers), len(requests), same[1] // 2]
    times = [f"{1e3 * t:.1f}" for t in (kernel, in_loop, in_stacks)]
    return [
        *map(str, sizes),
        *times,
        f"{loop_ratio:.1f}",
        f"{stacks_ratio:.1f}",
        f"{first:.1f}",
        f"{same[0] / same[1]:.2%}",
    ]


if __name__ == "__main__":
    main()
