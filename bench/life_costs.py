"""How fast is the evidence for labels beside plain numpy, and does it agree?

    python bench/life_costs.py [--quick]

Every marker of a body in motion is held against every point of some frames, a tenth of the markers unknown, through
the driver and by numpy in float64; the request is one that labelling makes many times over. Compiling is not counted.
"""

from collections.abc import Iterator

import numpy as np
from _numpy_life_evidence import evidence
from _rows import Row, run
from _timing import paired, seconds

from dshpm_jax._control.tuning import TUNING
from dshpm_jax._driver import Driver
from dshpm_jax._requests import LifeEvidence

BODY = np.array([150.0, 250.0, 500.0])  # mm, the spread of the markers
NEIGHBOURS, NOISE, UNKNOWN = 8, 2.0, 0.1
NEAR = 0.01  # nats that an answer in float32 may be off


def ask(markers: int, points: int, frames: int, rng: np.random.Generator) -> LifeEvidence:
    """A body that turns and shakes, seen among points that are none of its markers."""
    body = rng.normal(0, BODY, (markers, 3))
    apart = np.linalg.norm(body[:, None] - body[None], axis=-1)
    neighbours = apart.argsort(1)[:, 1 : NEIGHBOURS + 1]
    turn = np.linalg.qr(rng.normal(size=(frames, 3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))[:, None, None]
    there = body @ turn + rng.normal(0, NOISE, (frames, markers, 3)) + rng.uniform(-1000, 1000, (frames, 1, 3))
    others = there.mean(1, keepdims=True) + rng.normal(0, BODY, (frames, points - markers, 3))
    known = np.where(rng.random((frames, markers, 1)) < UNKNOWN, np.nan, there)
    frame, marker = (x.ravel() for x in np.indices((frames, markers)))
    distance_sd, marker_sd = np.sort(rng.uniform(3, 12, (markers, NEIGHBOURS)), axis=1), rng.uniform(4, 8, markers)
    seen = np.concatenate([there, others], axis=1)
    tables = neighbours, body[neighbours], body, distance_sd, marker_sd
    return LifeEvidence(known, seen, frame, marker, *tables, null=TUNING.null_model)


def through_driver(asked: LifeEvidence) -> np.ndarray:
    def control():
        return (yield asked)

    return next(Driver().run([control()]))


def rows(quick: bool) -> Iterator[Row]:
    for markers, points in ((49, 60),) if quick else ((27, 30), (49, 60), (100, 120)):
        asked = ask(markers, points, 100, np.random.default_rng(markers))
        case = f"{markers} markers among {points} points, 100 frames"
        first = seconds(lambda: through_driver(asked))
        (ours, _), (_, ratio) = paired([lambda: through_driver(asked), lambda: evidence(asked)], 3 if quick else 7)
        yield Row(case, "numpy / ours", ratio)
        yield Row(case, "ours (us a marker in a frame)", 1e6 * ours / len(asked.frame))
        yield Row(case, "first call (s)", first)
        same = np.abs(through_driver(asked) - evidence(asked)) < NEAR
        yield Row(case, f"answers within {NEAR:g} nats (%)", 100 * same.mean(), at_least=99.9)


if __name__ == "__main__":
    run(__doc__, rows)
