"""What a recording's own distances say of labels, each judged by what other trajectories show."""

import numpy as np
from takes import model

from dshpm_jax._control.full.evidence import evidence_in, sample_frames
from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.full.own_distances import _expected, _Sums, own_distances
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._types import NO_MATCH


def judged(problem, labels):
    return Solution.of(problem, labels, (yield from evidence_in(problem, labels, sample_frames(problem))))


def test_right_labels_have_evidence_and_a_margin(problem, truth, run):
    found, named = own_distances(problem, run(judged(problem, truth))), truth != NO_MATCH
    assert np.median(found.llr[named]) > 8.0 and (found.llr[named] > 0.0).mean() > 0.95
    assert (found.margin[named] > 0.0).mean() > 0.95
    assert (found.llr[~named] == 0.0).all() and (found.margin[~named] == 0.0).all()


def test_a_wrong_label_does_not_speak_for_itself(problem, truth, run):
    """The longest trajectory of a wrist, called the knee: all else of the knee says otherwise."""
    t, knee = problem.trajectories, model().markers.index("LKNE")
    of_wrist = np.flatnonzero(truth == model().markers.index("LWRA"))
    j = of_wrist[np.argmax((t.stop - t.start)[of_wrist])]
    wrong = truth.copy()
    wrong[j] = knee
    clash = (truth == knee) & (t.start < t.stop[j]) & (t.start[j] < t.stop)
    wrong[clash] = NO_MATCH
    found = own_distances(problem, run(judged(problem, wrong)))
    assert found.llr[j] < -5.0


def test_without_another_life_the_evidence_of_the_frames_stands(problem, truth, run):
    t, toe = problem.trajectories, model().markers.index("RTOE")
    of_toe = np.flatnonzero(truth == toe)
    j = of_toe[np.argmax((t.stop - t.start)[of_toe])]
    alone = np.where((truth == toe) & (np.arange(len(truth)) != j), NO_MATCH, truth)
    solution = run(judged(problem, alone))
    found = own_distances(problem, solution)
    assert found.llr[j] >= solution.llr[j, toe] and found.margin[j] >= 0.0


def test_distances_move_from_the_model_to_the_recording(problem):
    """With no frame the model's distance and spread; with many the recording's."""
    tried, (a, b) = np.array([0]), (0, 1)
    mean, spread = problem.model.pair_mean[a, b], problem.model.pair_spread[a, b]

    def expected(number: float, apart: float) -> tuple[float, float]:
        one = np.full((1, 34), number)
        found = _expected(problem, tried, _Sums(one, one * apart, one * (apart**2 + 1.0)))
        return found[0][0, b], found[1][0, b]

    between = TUNING.pair_noise_mm**2 + (TUNING.mean_share * mean) ** 2
    place, sd = expected(0.0, 0.0)
    np.testing.assert_allclose([place, sd], [mean, np.sqrt(spread**2 + TUNING.own_noise_mm**2 + between)])
    place, sd = expected(1e6, mean + 30.0)
    np.testing.assert_allclose([place, sd], [mean + 30.0, np.sqrt(1.0 + TUNING.own_noise_mm**2)], rtol=1e-3)
    assert mean < expected(10.0, mean + 30.0)[0] < mean + 30.0
