"""The matching kernel against one hypothesis at a time in numpy (section 4.2)."""

import matching_reference as reference
import numpy as np
import pytest
from matching_cases import make_request

from dshpm_jax._driver.matching import pad
from dshpm_jax._kernels import matching
from dshpm_jax._kernels.candidate_table import MAX_CANDIDATES
from dshpm_jax._kernels.completion import COMPLETIONS
from dshpm_jax._scoring import MaxResidual, MeanResidual, RmsResidual, ToleranceScore

MARGIN = 5e-4  # mm, or of a ratio: what double precision decides by less, single precision may decide otherwise
ERROR_TOLERANCE = 1e-3

SCORES = {
    MeanResidual: reference.mean_residual,
    RmsResidual: lambda relative: float(np.sqrt(np.mean(relative**2))),
    MaxResidual: lambda relative: float(np.max(relative)),
}

CASES = {  # the name says what is special about it
    "plain": dict(markers=4, points=60),
    "crowd of rivals": dict(markers=5, points=64, rivals=8),
    "many missing": dict(markers=8, points=40, missing=0.4, rivals=2),
    "two markers": dict(markers=2, points=30, missing=0.0),
    "three markers": dict(markers=3, points=50),
    "one join": dict(markers=6, points=50, pins=1, rivals=4),
    "three joins": dict(markers=7, points=50, pins=3, rivals=4),
    "virtual join": dict(markers=4, points=50, virtual=True, rivals=4),
    "two markers and a virtual join": dict(markers=2, points=50, virtual=True, missing=0.0),
    "few points": dict(markers=4, points=5),
    "nothing there": dict(markers=5, points=12, missing=1.0, rivals=0),
}
LARGE = {
    "large segment": dict(markers=16, points=60, missing=0.2),
    "large segment with joins": dict(markers=17, points=60, pins=4, virtual=True, rivals=3),
}
CROWDED = dict(markers=6, points=100, rivals=3)


def match(requests, score=None):
    """What the kernel finds for each request, by place of the hypothesis in the request."""
    problems, hypotheses = pad(requests)
    found = matching.match_segments(problems, hypotheses, ToleranceScore(), score or MeanResidual())
    rows = [np.asarray(field)[: int(found.num_tables)] for field in found[:6]]
    ends = np.cumsum([0] + [len(asked.pivot) for asked in requests])
    answers = []
    for k, asked in enumerate(requests):
        mine = (ends[k] <= rows[0]) & (rows[0] < ends[k + 1])
        hypothesis, assigned, *others = (field[mine] for field in rows)
        answers.append((hypothesis - ends[k], assigned, *others))
    return answers


def check(asked, answer, score=MeanResidual):
    """Compares one answer; returns how many hypotheses there were and how many had nothing to compare."""
    expected, unsure = reference.match_segment(asked, MAX_CANDIDATES, COMPLETIONS, SCORES[score])
    hypothesis, assigned, matched, error, accepted, fits = answer
    assert set(hypothesis.tolist()) ^ expected.keys() <= unsure
    compared = 0
    for row, k in enumerate(hypothesis.tolist()):
        one = expected.get(k)
        if one is None or one.margin < MARGIN:
            continue
        compared += 1
        columns = len(asked.target.markers)
        assert assigned[row, :columns].tolist() == one.assigned.tolist()
        assert (assigned[row, columns:] == reference.NO_MATCH).all()
        assert (matched[row], accepted[row], fits[row]) == (one.matched, one.accepted, one.fits)
        assert error[row] == pytest.approx(one.error, abs=ERROR_TOLERANCE, rel=ERROR_TOLERANCE)
    check_order([expected[k] for k in hypothesis.tolist() if k in expected])
    return len(expected), len(expected) - compared


def check_order(ranked):
    """Fuller tables come first, then those of less cost, then those that were asked for first."""
    for first, second in zip(ranked, ranked[1:]):
        assert first.filled >= second.filled
        if first.filled == second.filled:
            assert first.cost <= second.cost + MARGIN
            assert first.cost != second.cost or first.hypothesis < second.hypothesis


def check_batches(cases, seeds, score=MeanResidual, most=0.08):
    """Checks all requests, of whose hypotheses at `most` this share may be too near to a threshold to compare."""
    hypotheses = left_out = 0
    for seed in seeds:
        rng = np.random.default_rng(seed)
        requests = [make_request(rng, **case) for case in cases]
        for asked, answer in zip(requests, match(requests, score()), strict=True):
            numbers = check(asked, answer, score)
            hypotheses, left_out = hypotheses + numbers[0], left_out + numbers[1]
    assert left_out < most * hypotheses, f"{left_out} of {hypotheses} were too near to a threshold to compare"
    return hypotheses


def test_a_batch_of_all_kinds():
    assert check_batches(CASES.values(), range(2)) > 300


def test_large_segments():
    """With another score, as a larger bucket is another program anyway; more columns are more near decisions."""
    assert check_batches(LARGE.values(), [20], RmsResidual, most=0.15) > 25


def test_crowded_frames():
    assert check_batches([CROWDED], [30, 31], MaxResidual) > 30


def test_what_is_compared_holds_every_kind_of_outcome():
    rng = np.random.default_rng(0)
    answers = match([make_request(rng, **case) for case in CASES.values()])
    accepted = np.concatenate([answer[4] for answer in answers])
    fits = np.concatenate([answer[5] for answer in answers])
    assert 0.02 < accepted.mean() < 0.9
    assert (fits == 1).any() and (fits > 4).any()
    nothing_there = answers[list(CASES).index("nothing there")]
    assert not nothing_there[4].any()


def test_a_known_join_is_never_another_point():
    rng = np.random.default_rng(1)
    requests = [make_request(rng, 7, 50, pins=3, rivals=4) for _ in range(8)]
    for asked, (_, assigned, *_) in zip(requests, match(requests), strict=True):
        pinned = asked.pinned != reference.NO_MATCH
        held = assigned[:, : len(pinned)][:, pinned]
        assert ((held == asked.pinned[pinned]) | (held == reference.NO_MATCH)).all()


def test_no_point_is_taken_twice_or_out_of_bounds():
    rng = np.random.default_rng(2)
    requests = [make_request(rng, **case) for case in CASES.values()]
    for asked, (_, assigned, *_) in zip(requests, match(requests), strict=True):
        for row in assigned:
            taken = row[row != reference.NO_MATCH]
            assert len(set(taken)) == len(taken) and (taken < len(asked.points)).all()
            known = asked.pinned[asked.pinned != reference.NO_MATCH]
            assert (asked.free[taken] | np.isin(taken, known)).all()


def test_the_true_match_is_accepted():
    rng = np.random.default_rng(3)
    for _ in range(10):
        asked = make_request(rng, 5, 50, missing=0.0, rivals=0)
        _, _, matched, error, accepted, _ = match([asked])[0]
        free = asked.free.sum() / len(asked.free)
        assert accepted.any() or free < 1.0
        assert error[accepted].min(initial=0.0) < 1.0 and (matched[accepted] >= asked.target.need).all()
