"""Mean distances of labelled markers, kept by pairs of trajectories."""

import numpy as np
import pytest

from dshpm_jax._control.full.mean_distances import label_sums, mean_distances
from dshpm_jax._control.pair_sums import PairSums
from dshpm_jax._geometry import evenly_spaced
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH


def test_mean_distances_by_a_slow_loop(problem, truth):
    t, frames = problem.trajectories, evenly_spaced(problem.trajectories.num_frames, 100, rounded=True)
    found = mean_distances(label_sums(problem.pair_sums, truth, 34), problem.pair_sums.frames)
    for a, b in ((0, 1), (3, 9), (20, 33)):
        apart = []
        for frame in frames:
            here, points = t.at(int(frame))
            place = {int(truth[j]): point for j, point in zip(here, points) if truth[j] != NO_MATCH}
            if a in place and b in place:
                apart.append(np.linalg.norm(place[a] - place[b]))
        assert found.share[a, b] == len(apart) / len(frames)
        np.testing.assert_allclose([found.mean[a, b], found.sd[a, b]], [np.mean(apart), np.std(apart)], atol=1e-6)


def test_pairs_are_there_both_ways_and_by_the_first(problem):
    pairs = problem.pair_sums
    either = {*zip(pairs.one.tolist(), pairs.other.tolist(), strict=True)}
    assert len(either) == len(pairs.one) and either == {(b, a) for a, b in either}
    some = np.array([3, 0, 7])
    which = pairs.pairs_of(some)
    np.testing.assert_array_equal(np.sort(which), np.flatnonzero(np.isin(pairs.one, some)))


@pytest.mark.parametrize("shape", [(0, 3), (5, 0), (5, 1), (1, 2)])
def test_hardly_anything_there(shape):
    tracks = from_columns(np.ones((*shape, 3)), 100.0)
    pairs = PairSums.of(tracks, np.arange(shape[0]))
    expected = shape[1] * (shape[1] - 1) if shape[0] else 0
    assert len(pairs.one) == expected and len(pairs.pairs_of(np.arange(len(tracks)))) == expected
