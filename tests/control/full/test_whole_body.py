"""The whole body prefers right labels to exchanged ones, whatever is labelled besides."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from takes import model

from dshpm_jax._control.full.mean_distances import label_sums, mean_distances, mean_llr
from dshpm_jax._control.full.whole_body import whole_body_gain, whole_body_gains
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._types import NO_MATCH


def worth(problem, identity) -> float:
    """What all pairs of labelled markers say, from the table of all (nats a frame)."""
    sums = label_sums(problem.pair_sums, identity, 34)
    found = mean_distances(sums, problem.pair_sums.frames)
    llr = found.share * mean_llr(TUNING, found, problem.model.pair_mean, problem.model.pair_spread)
    return float(llr.sum()) / 2 * TUNING.whole_body_weight / problem.prepared.partners


def exchanged(identity, one, other):
    a, b = (model().markers.index(name) for name in (one, other))
    return np.where(identity == a, b, np.where(identity == b, a, identity))


@given(seed=st.integers(0, 10_000))
@settings(max_examples=30)
def test_a_move_gains_what_the_tables_of_all_differ_by(problem_and_truth, seed):
    problem, truth = problem_and_truth
    rng = np.random.default_rng(seed)
    which = rng.choice(len(truth), 4, replace=False)
    labels = rng.integers(NO_MATCH, 34, 4).astype(np.int32)
    after = truth.copy()
    after[which] = labels
    both = (truth != NO_MATCH) & (after != NO_MATCH)
    before = np.where(both, truth, NO_MATCH)
    expected = worth(problem, np.where(both, after, NO_MATCH)) - worth(problem, before)
    (found,) = whole_body_gains(problem, truth, [(which, labels)])
    assert found == pytest.approx(expected, abs=1e-9)
    assert whole_body_gain(problem, after, truth) == pytest.approx(-expected, abs=1e-9)


@pytest.mark.parametrize("pair", [("LWRA", "LWRB"), ("LELB", "LWRA"), ("LTOE", "LHEE"), ("LFHD", "RFHD")])
def test_right_labels_are_preferred(problem, truth, pair):
    assert whole_body_gain(problem, truth, exchanged(truth, *pair)) < -0.5


def test_a_label_is_neither_dearer_nor_cheaper_for_it(problem, truth):
    less = np.where(truth == model().markers.index("LKNE"), NO_MATCH, truth)
    assert whole_body_gain(problem, truth, less) == 0.0 == whole_body_gain(problem, less, truth)
    assert whole_body_gain(problem, truth, truth) == 0.0
