"""The frames in which trajectories are judged, and what they say."""

import numpy as np
import pytest

from dshpm_jax._control.full.evidence import evidence_after, evidence_in, fewer_frames, labels_in, sample_frames
from dshpm_jax._types import NO_MATCH


def test_every_trajectory_is_sampled(problem):
    seen = np.unique(problem.trajectories.index[sample_frames(problem)])
    assert set(range(len(problem.trajectories))) <= set(seen.tolist())


@pytest.mark.parametrize("step", [1, 3, 1000])
def test_every_trajectory_is_in_some_of_fewer_frames(problem, step):
    frames = sample_frames(problem)
    few = fewer_frames(problem, frames, step)
    assert set(few.tolist()) <= set(frames.tolist()) and (np.diff(few) > 0).all()
    assert len(few) == len(frames) if step == 1 else len(few) < len(frames)
    assert set(np.unique(problem.trajectories.index[few])) == set(np.unique(problem.trajectories.index[frames]))


def test_what_is_judged_anew_is_what_would_be_judged_afresh(problem, truth, run):
    """Only markers with a neighbour that moved are asked for; the answer is the same, to the last bit."""
    frames = sample_frames(problem)
    fewer = np.where(np.arange(len(truth)) % 5 == 0, NO_MATCH, truth)
    before = run(evidence_in(problem, truth, frames))
    after = run(evidence_after(problem, before, labels_in(problem, fewer, frames)))
    afresh = run(evidence_in(problem, fewer, frames))
    for name in ("frames", "labels", "llr", "distance_llr"):
        np.testing.assert_array_equal(getattr(after, name), getattr(afresh, name))
    assert (before.llr != after.llr).any()
