"""Labels of a cluster that are shifted are put right; what is right is left."""

import numpy as np
import pytest
from takes import model

from dshpm_jax._control.full.evidence import evidence_in, sample_frames
from dshpm_jax._control.full.mean_distances import MeanDistances
from dshpm_jax._control.full.neighbourhoods.permutations import _llr, propose_permutations
from dshpm_jax._control.full.neighbourhoods.side_swaps import swap_sides
from dshpm_jax._control.full.objective import Incumbent, Solution
from dshpm_jax._types import NO_MATCH


def judged(problem, labels):
    return Solution.of(problem, labels, (yield from evidence_in(problem, labels, sample_frames(problem))))


def shifted(truth, *names):
    """The labels of some markers passed on round a ring; the last goes without."""
    ring = [model().markers.index(name) for name in names]
    wrong = np.where(truth == ring[-1], NO_MATCH, truth)
    for one, following in zip(ring, ring[1:]):
        wrong = np.where(truth == one, following, wrong)
    return wrong


@pytest.mark.parametrize(
    "names", [("LFHD", "RFHD", "LBHD", "RBHD"), ("LWRA", "LWRB", "LFIN"), ("RTOE", "RHEE", "RANK")]
)
def test_labels_shifted_by_one_are_proposed_back_and_put_right(problem, truth, run, names):
    wrong = shifted(truth, *names)
    moved = (wrong != truth) & (wrong != NO_MATCH)
    solution = run(judged(problem, wrong))
    back = [m for m in propose_permutations(problem, solution) if set(m.trajectories) >= set(np.flatnonzero(moved))]
    assert any((dict(zip(m.trajectories, m.labels))[j] == truth[j] for j in np.flatnonzero(moved)) for m in back)
    incumbent = Incumbent(solution)
    run(swap_sides(problem, incumbent))
    assert (incumbent.solution.identity[moved] == truth[moved]).all()


def test_right_labels_stay(problem, truth, run):
    solution = run(judged(problem, truth))
    assert all(move.promise < 0 for move in propose_permutations(problem, solution))


def test_clusters_are_near_markers_each_once(problem):
    clusters = [tuple(cluster) for cluster in problem.prepared.clusters]
    assert len(set(clusters)) == len(clusters) and {m for cluster in clusters for m in cluster} == set(range(34))
    assert all(2 <= len(cluster) <= 6 and list(cluster) == sorted(cluster) for cluster in clusters)


def test_a_metre_that_is_two_centimetres_off_loses_a_nat_and_a_half(problem):
    """A long distance may differ from the model's by its share of the length; a short one by the noise alone."""
    still = np.ones(2)
    for length, off, lost in ((1000.0, 20.0, 1.52), (50.0, 10.0, 2.15)):
        mean, sd = np.full(2, length), np.full(2, 1.0)
        found = MeanDistances(still, mean + [0.0, off], still)
        exact, wrong = _llr(problem, found, mean, sd)
        assert exact - wrong == pytest.approx(lost, abs=0.01)


def test_no_pair_decides_alone(problem):
    found = MeanDistances(np.array([1.0, 0.5]), np.array([900.0, 900.0]), np.ones(2))
    assert _llr(problem, found, np.full(2, 50.0), np.ones(2)).tolist() == [-5.0, -2.5]
