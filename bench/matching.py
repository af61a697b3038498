"""How fast is our segment matching beside numpy's?

    python bench/matching.py [--quick]

One segment among the points of a frame, under every pivot hypothesis, alone and sixteen at once: through the driver,
by a plain loop over the hypotheses that survive culling, by stacks of them with batched `np.linalg.svd`, and by a
`while_loop` of one hypothesis mapped over all, of which neither tables nor completion are counted. The first call
(compiling) is timed apart; then they run in turns. Ratios are medians over the runs of one turn's times.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
from _naive_matching import iterate, prepared
from _numpy_matching import match_in_loop, match_in_stacks
from _rows import Row, run
from _timing import paired, seconds

from dshpm_jax._driver import Driver
from dshpm_jax._requests import MatchSegment, SegmentMatches, Target
from dshpm_jax._types import NO_MATCH

PATIENCE = 20.0  # seconds for a case; one that takes longer is run twice only
QUICK = ((60, 8, 1), (60, 8, 16))  # points, markers, segments at once
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


def rows(quick: bool) -> Iterator[Row]:
    for points, markers, flight in QUICK if quick else product((60, 120), (4, 8, 16), (1, 16)):
        requests = [ask(markers, points, np.random.default_rng([points, markers, k])) for k in range(flight)]
        yield from contest(f"{flight} of {markers} markers among {points} points", requests, 3 if quick else 7)


def contest(case: str, requests: Sequence[MatchSegment], runs: int) -> Iterator[Row]:
    first = seconds(lambda: through_driver(requests))
    ours = through_driver(requests)
    loop, stacks = ([match(request) for request in requests] for match in (match_in_loop, match_in_stacks))
    same = np.sum([shared(*pair) for theirs in (loop, stacks) for pair in zip(ours, theirs)], axis=0)
    if same[0] < 0.99 * same[1]:
        raise SystemExit(f"only {same[0]} of {same[1]} matches are the same: these are not the same algorithm")
    naive = [prepared(request) for request in requests]
    contestants = [
        lambda: through_driver(requests),
        lambda: [match_in_loop(request) for request in requests],
        lambda: [match_in_stacks(request) for request in requests],
        lambda: [np.asarray(iterate(*one)) for one in naive],
    ]
    contestants[3]()  # compiles
    turn = sum(seconds(contestant) for contestant in contestants)
    (kernel, *_), (_, in_loop, in_stacks, in_map) = paired(contestants, max(2, min(runs, int(PATIENCE / turn))))
    yield Row(case, "numpy loop / ours", in_loop, at_least=25.0)
    yield Row(case, "batched numpy / ours", in_stacks, at_least=7.0)
    yield Row(case, "mapped while_loop with svd / ours", in_map)
    yield Row(case, "ours (ms)", 1e3 * kernel)
    yield Row(case, "first call (s)", first)
    yield Row(case, "same matches (%)", 100 * same[0] / same[1], at_least=99.9)


if __name__ == "__main__":
    run(__doc__, rows)
