"""The fit of the confidences finds what is planted, leaves out what it should, and means what labelling means."""

from dataclasses import replace

import numpy as np
import pytest
from _calibration import (
    LEAST_POOR,
    Findings,
    Labels,
    Numbers,
    chance,
    finding_chance,
    fit_logistic,
    fitted,
    left_out,
    log_loss,
    logistic,
    reliability,
)
from _cases import cases, data_set, folders_of
from _planting import EXCHANGES, NO_MARKER, planted
from _truth import counts, judged_trajectories
from calibrate import gathered, judged_labels, numbers_of, result, show
from calibrate import judged as judged_sets
from takes import model, take

from dshpm_jax import Labelling, Settings, label_many
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._driver import Driver
from dshpm_jax._pretracking import pretrack
from dshpm_jax._trajectories import by_marker
from dshpm_jax.synthesis import person

WEIGHTS = (0.6, 0.75, 1.45, 0.0, 0.0, 0.0)
NOW = Numbers(WEIGHTS, 0.8, 0.83, 0.86, 0.5)
NO_FINDINGS = Findings(np.array([], str), np.array([]), np.array([], bool))


def drawn(coefficients, data_set: str, seed: int, size: int = 8000, fit: float = 1.1, rescaled: bool = False) -> Labels:
    """Labels that are right as often as these coefficients have it, eight recordings of them."""
    rng = np.random.default_rng(seed)
    llr, seconds = rng.uniform(-4, 6, size), 10 ** rng.uniform(-2, 1, size)
    features = np.stack([np.ones(size), llr, np.log10(seconds), *np.zeros((3, size))], 1)
    right = rng.random(size) < logistic(features[:, :3] @ np.array(coefficients)[:3])
    number = 10 * seed + np.arange(size) % 8
    return Labels(np.full(size, data_set), number, features, right, np.full(size, fit), np.full(size, rescaled))


def together(*some: Labels) -> Labels:
    return Labels(*(np.concatenate([vars(one)[name] for one in some]) for name in vars(some[0])))


def test_planted_coefficients_are_found():
    planted = np.array([-0.4, 0.5, 0.9])
    labels = drawn(planted, "a", 0, 40000)
    np.testing.assert_allclose(fit_logistic(labels.features, labels.right, WEIGHTS)[:3], planted, atol=0.06)


def test_coefficients_stay_where_nothing_is_said_and_finite_where_all_is_right():
    labels = drawn([0.6, 0.75, 1.45], "a", 0, 50)
    np.testing.assert_allclose(fit_logistic(labels.features[:0], labels.right[:0], WEIGHTS), WEIGHTS)
    found = fit_logistic(labels.features, np.ones(50, bool), WEIGHTS)
    assert np.isfinite(found).all() and (logistic(labels.features @ found) > 0.5).all()


def test_a_data_set_that_is_left_out_has_no_part_in_its_numbers():
    sets = {name: drawn([0.6, 0.75, 1.45], name, k) for k, name in enumerate("abc")}
    sets["c"] = replace(sets["c"], right=~sets["c"].right)
    findings = Findings(np.repeat(list("abc"), 4), np.tile([1.0, 4.0, 9.0, 16.0], 3), np.tile([0, 1, 1, 1], 3) > 0)
    found = dict(left_out(together(*sets.values()), findings, NOW))
    assert list(found) == ["a", "b", "c"]
    assert found["c"] == fitted(together(sets["a"], sets["b"]), findings.where(findings.data_set != "c"), NOW)
    assert found["a"].weights[1] < 0.5 * found["c"].weights[1]


def test_a_share_for_badly_fitting_models_is_found():
    sound, poor = drawn([2.0, 1.0, 1.0], "a", 0), drawn([-9.0, 0.0, 0.0], "b", 1, fit=0.62)
    poor = replace(poor, right=np.arange(len(poor)) % 4 > 0)
    found = fitted(together(sound, poor), NO_FINDINGS, NOW)
    assert 0.62 < found.poor_fit_below <= 0.7 and found.poor_fit_share == pytest.approx(0.75)
    assert found.weights == fitted(sound, NO_FINDINGS, NOW).weights
    few = poor.where(np.isin(poor.recording, np.unique(poor.recording)[: LEAST_POOR - 1]))
    assert fitted(together(sound, few), NO_FINDINGS, NOW)[1:3] == NOW[1:3]


def test_rescaled_models_have_a_share_of_their_own():
    own, other = drawn([2.0, 1.0, 1.0], "a", 0), drawn([0.0, 0.0, 0.0], "b", 1, rescaled=True)
    found = fitted(together(own, other), NO_FINDINGS, NOW)
    assert found.rescaled_share == pytest.approx(other.right.mean())
    assert found.weights == fitted(own, NO_FINDINGS, NOW).weights
    assert chance(found, other).max() <= found.rescaled_share


def test_findings_are_as_sure_as_they_are_right():
    rng = np.random.default_rng(0)
    llr = rng.uniform(0, 20, 20000)
    findings = Findings(np.full(len(llr), "a"), llr, rng.random(len(llr)) < logistic(0.2 * llr))
    found = fitted(drawn(WEIGHTS, "a", 0), findings, NOW)
    assert found.finding_per_llr == pytest.approx(0.2, abs=0.01)
    assert log_loss(finding_chance(found, findings), findings.right) < log_loss(
        finding_chance(NOW, findings), findings.right
    )


def test_how_far_probabilities_hold():
    p, right = np.array([0.1, 0.7, 0.94, 0.95, 0.99, 1.0]), np.array([1, 1, 0, 1, 1, 0]) > 0
    assert reliability(p, right) == [(2, 0.5), (1, 1.0), (2, 0.5)]
    assert log_loss(np.array([0.5, 0.25]), np.array([True, False])) == pytest.approx((np.log(2) - np.log(0.75)) / 2)
    assert np.isfinite(log_loss(np.array([1.0]), np.array([False])))


def test_the_fitted_form_is_that_of_labelling():
    recording, _ = take(3)
    as_it_is = next(label_many([recording], [model()], Settings(min_confidence=0.0)))
    problem, identity, features, fit = next(Driver().run([judged_labels(pretrack(recording), model(), False)]))
    which = np.flatnonzero(identity >= 0)
    labels = gathered([("a", "one", features[which], np.ones(len(which), bool), fit, False)])
    np.testing.assert_array_equal(as_it_is.identity, identity)
    np.testing.assert_allclose(chance(numbers_of(TUNING), labels), as_it_is.confidence[which], atol=1e-6)
    assert len(problem.trajectories) == len(identity) and fit == pytest.approx(as_it_is.stats["model_fit"], abs=1e-4)


def test_the_table_and_what_is_kept(capsys):
    labels = together(drawn(WEIGHTS, "set one", 0, 400), drawn(WEIGHTS, "set two", 1, 400))
    rows = list(judged_sets(labels, NO_FINDINGS, NOW))
    show(rows)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5 and "set one" in lines[1] and len({len(line) for line in lines[:2]}) == 1
    found = result(labels, NO_FINDINGS, NOW, fitted(labels, NO_FINDINGS, NOW), rows)
    assert found["fitted_on"]["trajectories"] == {"set one": 400, "set two": 400}
    assert found["numbers"]["poor_fit_share"] == {"today": 0.83, "fitted": 0.83}


@pytest.mark.parametrize(
    ("group", "wanted"),
    [
        ("opencap-s4-47", "opencap-s4"),
        ("climb-39-static-only", "climb"),
        ("thin-model", "thin-model"),
        ("zoo-59-without-anna", "zoo-data"),
        ("zoo-59", "zoo-data"),
    ],
)
def test_groups_of_one_data_set(group, wanted, tmp_path):
    listed = tmp_path / "cases.toml"
    listed.write_text('[[group]]\nname = "zoo-59"\nfolder = "zoo-data"\n')
    assert data_set(group, folders_of([listed])) == wanted


def test_a_folder_without_cases_is_refused(tmp_path):
    with pytest.raises(SystemExit, match="no recording with a truth"):
        cases(tmp_path)


def test_planted_errors_are_where_they_are_said_to_be():
    places = person(34, frames=120, seed=1).recording.points
    points, real = planted(places, 60.0, np.random.default_rng(2))
    frame, column = np.nonzero(real != NO_MARKER)
    np.testing.assert_array_equal(points[frame, column], places[frame, real[frame, column]])
    frame, column = np.nonzero(real == NO_MARKER)
    assert len(frame) and (np.linalg.norm(points[frame, column] - places[frame, column], axis=-1) > 30).all()
    exchanged = real != np.arange(real.shape[1])
    assert 2 <= (exchanged & (real != NO_MARKER)).any(0).sum() <= 2 * EXCHANGES


def test_labels_are_held_against_the_truth():
    recording, right = take(3)
    labelling = next(label_many([recording], [model()]))
    truth = truth_of(labelling, right.numbered_by(model().markers))
    which, good = judged_of(labelling, truth)
    assert len(which) == (labelling.identity >= 0).sum() and good.all()
    assert counts(labelling, truth).f1 == 1.0
    wrong = replace(labelling, identity=np.where(labelling.identity == 4, 5, labelling.identity))
    which, good = judged_of(wrong, truth)
    np.testing.assert_array_equal(good, labelling.identity[which] != 4)
    assert counts(wrong, truth).f1 < 1.0
    truth["judged"][:, 5] = False
    which, good = judged_of(wrong, truth)
    assert good.all() and 5 not in wrong.identity[which]


def judged_of(labelling: Labelling, truth: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    return judged_trajectories(labelling.trajectories, labelling.identity, labelling.model, truth)


def truth_of(labelling: Labelling, identities: np.ndarray) -> dict[str, np.ndarray]:
    """The truth of a take, as files have it."""
    places = by_marker(labelling.recording.points, identities, model().num_markers)
    judged = np.ones(places.shape[:2], bool)
    return {"labels": np.array(model().markers), "xyz": places, "judged": judged, "units": np.array("mm")}
