"""The driver: answers in order, independent of company, in few programs."""

from dataclasses import replace

import numpy as np
import pytest
import reference
from matching_cases import make_request

from dshpm_jax._buckets import bucket
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._driver import Driver, driver
from dshpm_jax._requests import CountFits, FitPoses, Gather, LifeEvidence, Segmentation


def ask(*requests):
    answers = []
    for request in requests:
        answers.append((yield request))
    return answers


def run(*controls, **options):
    return list(Driver(**options).run(controls))


def fits(rng, count, columns):
    shape = rng.normal(0, 100, (count, columns, 3))
    points = shape + rng.uniform(-2000, 2000, (count, 1, 3)) + rng.normal(0, 3, shape.shape)
    weights = rng.choice([0.0, 0.5, 1.0], (count, columns))
    weights[:, :4] = 1.0
    return FitPoses(shape, np.where(weights[..., None] > 0, points, np.nan), weights)


def test_results_come_in_the_order_of_the_controls():
    def control(steps, name):
        for _ in range(steps):
            yield Segmentation(np.zeros((4, 2, 3)), 100.0, 0.1)
        return name

    steps = [3, 0, 5, 1, 0, 2]
    assert run(*(control(n, k) for k, n in enumerate(steps)), in_flight=2) == list(range(6))
    assert run() == []


def test_no_more_controls_in_flight_than_asked_for():
    alive, most = set(), []

    def control(k):
        alive.add(k)
        most.append(len(alive))
        for _ in range(1 + k % 3):
            yield Segmentation(np.zeros((4, 2, 3)), 100.0, 0.1)
        alive.discard(k)

    run(*(control(k) for k in range(10)), in_flight=3)
    assert max(most) == 3


def test_results_do_not_wait_for_the_last_control():
    def control():
        yield Segmentation(np.zeros((4, 2, 3)), 100.0, 0.1)
        return "done"

    def controls():
        yield control()
        yield control()
        raise AssertionError("asked for before the first result was given")

    results = Driver(in_flight=1).run(controls())
    assert next(results) == "done"


def test_together_gives_the_results_of_all():
    def outer():
        inner = (ask(fits(rng, 1, 5)), ask(), ask(fits(rng, 2, 5), fits(rng, 3, 5)))
        nested = Gather((ask(fits(rng, 4, 5)),))
        found = yield Gather((*inner, ask(nested)))
        return [[len(x.rms) for x in one] for one in found[:3]], len(found[3][0][0][0].rms)

    rng = np.random.default_rng(0)
    assert run(outer()) == [([[1], [], [2, 3]], 4)]
    assert run(ask(Gather(()))) == [[[]]]


def test_poses_are_those_of_the_reference():
    rng = np.random.default_rng(1)
    requests = [fits(rng, count, columns) for count, columns in ((3, 4), (5, 8), (1, 6))]
    found = run(ask(*requests))[0]
    for asked, poses in zip(requests, found, strict=True):
        for k in range(len(asked.shape)):
            rotation, translation, rms = reference.rigid_fit(asked.shape[k], asked.points[k], asked.weights[k])
            np.testing.assert_allclose(poses.rotation[k], rotation, atol=1e-4)
            np.testing.assert_allclose(poses.translation[k], translation, atol=0.02)
            assert poses.rms[k] == pytest.approx(rms, abs=2e-3) and poses.rank[k] >= 2


def test_a_window_without_points_is_no_trouble():
    """Warnings are errors here, as a mean of nothing would give one."""
    (found,) = run(ask(Segmentation(np.full((4, 2, 3), np.nan), 100.0, 0.1)))[0]
    assert found.shape == (2, 2)


def test_segmentation_keeps_what_moves_together():
    """Eqs. 1 and 2: points 0 and 1 are rigid, 2 is far off, 3 comes and goes, 4 is seen with the others too rarely."""
    window = np.zeros((11, 5, 3))
    window[:, :, 0] = [0, 100, 5000, 200, 300]
    window[:, 3, 1] = np.linspace(0, 200, 11)
    window[2:, 4] = np.nan
    window += np.random.default_rng(2).uniform(-2000, 2000, (11, 1, 3))
    others = np.random.default_rng(3).uniform(0, 500, (11, 30, 3))
    alone = run(ask(Segmentation(window, 400.0, 0.1)))[0]
    company = run(*(ask(Segmentation(w, 400.0, 0.1)) for w in (others, window)))[1]
    expected = [(0, 1), (0, 4), (1, 4), (2, 4), (3, 4)]
    for (found,) in (alone, company):
        assert [(i, j) for i in range(5) for j in range(i + 1, 5) if found[i, j]] == expected
        assert found.shape == (5, 5) and (found == found.T).all()


def test_controls_that_wait_for_the_same_request_are_answered_from_one_call(monkeypatch):
    asked, answer = [], driver.segment
    monkeypatch.setattr(driver, "segment", lambda requests: asked.extend(requests) or answer(requests))
    window = np.random.default_rng(5).uniform(0, 500, (11, 6, 3))
    shared, other = Segmentation(window, 400.0, 0.1), Segmentation(window + 1.0, 400.0, 0.1)
    found = run(ask(shared), ask(other), ask(shared))
    assert asked == [shared, other]
    for (matrix,) in found:
        np.testing.assert_array_equal(matrix, found[0][0])


def test_a_match_does_not_depend_on_its_company():
    rng = np.random.default_rng(3)
    kinds = [dict(pins=1), dict(pins=2), dict(pins=1, virtual=True), dict(points=20), dict(points=3, missing=0.5)]
    requests = [make_request(rng, **({"markers": 5, "points": 50, "rivals": 3} | kind)) for kind in kinds]
    together = run(*(ask(request) for request in requests))
    backwards = run(ask(*requests[::-1]))[0][::-1]
    for request, (first,), second in zip(requests, together, backwards, strict=True):
        alone = run(ask(request))[0][0]
        for found in (first, second):
            assert found.assigned.shape == alone.assigned.shape
            for name in ("assigned", "matched", "accepted", "fits"):
                np.testing.assert_array_equal(getattr(found, name), getattr(alone, name))
            np.testing.assert_allclose(found.error, alone.error, atol=1e-4)


def test_more_requests_than_fit_one_call():
    rng = np.random.default_rng(4)
    requests = [make_request(rng, 4, 30, pins=1) for _ in range(70)]
    found = run(*(ask(request) for request in requests))
    for k in (0, 31, 32, 69):
        alone = run(ask(requests[k]))[0][0]
        np.testing.assert_array_equal(found[k][0].assigned, alone.assigned)


def test_fits_are_counted_for_each_control_with_all_that_it_runs():
    rng = np.random.default_rng(6)

    def counted(*controls):
        yield Gather(controls)
        return (yield CountFits())

    match = make_request(rng, 4, 30)
    controls = (
        counted(ask(fits(rng, 3, 5)), ask(match, fits(rng, 2, 5))),
        counted(ask(fits(rng, 7, 4)), ask()),
        counted(),
    )
    (answer,) = run(ask(match))[0]
    assert run(*controls) == [3 + int(answer.fits.sum()) + 2, 7, 0]


def test_the_paper_fits_no_hypothesis_after_the_first_acceptable():
    match = make_request(np.random.default_rng(3), 5, 50, rivals=3)
    (found,) = run(ask(match))[0]
    first = replace(match, first_acceptable=True)
    accepted = np.flatnonzero(found.accepted)
    assert match.fits(found) == found.fits.sum() and first.acceptable(found).tolist() == accepted.tolist()
    assert first.fits(found) == found.fits[: accepted[0] + 1].sum() < match.fits(found)
    banned = replace(first, banned=tuple((0, int(found.assigned[k, 0])) for k in accepted[:1]))
    assert accepted[0] not in banned.acceptable(found)


def test_evidence_is_asked_with_one_null_model_a_call():
    rng = np.random.default_rng(7)
    one = evidence(rng, 20)
    other = replace(one, null=replace(one.null, background_mm=2 * one.null.background_mm))
    plain, wider = (found[0] for found in run(ask(one), ask(other)))
    assert one.group() != other.group() and one.fits(plain) == 3 * 20
    assert (wider >= plain).all() and (wider > plain).any()


def test_a_stranger_is_no_request():
    with pytest.raises(TypeError, match="str"):
        run(ask("match this"))


def test_too_much_for_the_largest_bucket():
    assert [bucket(n, (8, 18), "markers") for n in (1, 8, 9, 18)] == [8, 8, 18, 18]
    with pytest.raises(ValueError, match="19 markers at once, more than 18"):
        bucket(19, (8, 18), "markers")


def evidence(rng, lanes, markers=30, slots=40, frames=60, neighbours=6):
    """Markers near where they should be, about half of them known, among points of which some are theirs."""
    body = rng.normal(0, 300, (markers, 3))
    identified = body + rng.normal(0, 5, (frames, markers, 3))
    points = np.concatenate([identified, rng.normal(0, 500, (frames, slots - markers, 3))], axis=1)
    identified = np.where(rng.random((frames, markers, 1)) < 0.5, identified, np.nan)
    around = np.argsort(np.linalg.norm(body[:, None] - body, axis=-1), axis=1)[:, 1 : 1 + neighbours]
    frame, marker = rng.integers(frames, size=lanes), rng.integers(markers, size=lanes)
    distance_sd, marker_sd = np.sort(rng.uniform(2, 8, (markers, neighbours))), np.full(markers, 5.0)
    tables = around, body[around], body, distance_sd, marker_sd
    return LifeEvidence(identified, points, frame, marker, *tables, null=TUNING.null_model)


def test_company_changes_no_bit_of_the_evidence():
    """A hair's breadth decides between searches that are equally good, so that nearly the same is not enough."""
    rng = np.random.default_rng(5)
    asked = [evidence(rng, lanes) for lanes in (53, 1491, 700, 20)]
    (together,) = run(ask(*asked))
    side_by_side = run(*(ask(one) for one in asked))
    alone = [run(ask(one))[0][0] for one in asked]
    for k in range(len(asked)):
        np.testing.assert_array_equal(together[k], alone[k])
        np.testing.assert_array_equal(side_by_side[k][0], alone[k])
