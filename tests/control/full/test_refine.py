"""Labels judged and assigned in turn, and the moves that single assignments cannot make."""

import numpy as np
import pytest
from takes import model

from dshpm_jax._control.full.assignment import any_overlap
from dshpm_jax._control.full.objective import Incumbent
from dshpm_jax._control.full.refine import improve, refine_best, refine_labels
from dshpm_jax._types import NO_MATCH


@pytest.mark.parametrize("pair", [("LWRA", "LWRB"), ("RFHD", "LBHD"), ("LTOE", "LHEE")])
def test_exchanged_labels_are_mended(problem, truth, run, pair):
    a, b = (model().markers.index(name) for name in pair)
    swapped = np.where(truth == a, b, np.where(truth == b, a, truth))
    incumbent = Incumbent(run(refine_labels(problem, swapped)))
    run(improve(problem, incumbent))
    touched = np.isin(truth, [a, b])
    assert (incumbent.solution.identity[touched] == truth[touched]).all()


def test_no_label_stays_on_two_points_of_a_frame(problem, truth, run):
    """Even where labels to start from say so, as exchanges for a while may: both would count, and so win."""
    t, twice = problem.trajectories, np.array(truth)
    longest = np.argsort(t.start - t.stop, kind="stable")
    first, second = longest[np.isin(truth[longest], problem.targets[0].markers)][:2]
    twice[second] = truth[first]
    assert any_overlap(twice, t.start, t.stop) and not any_overlap(truth, t.start, t.stop)
    solution = run(refine_labels(problem, twice))
    assert not any_overlap(solution.identity, t.start, t.stop) and np.isfinite(solution.objective)


def test_the_best_of_several_whatever_fits_into_memory(problem, truth, run, monkeypatch):
    starts = [np.where(np.arange(len(truth)) % k == 0, NO_MATCH, truth) for k in (2, 3, 7)]
    alone = [run(refine_labels(problem, start)) for start in starts]
    for limit in (1, 1 << 40):
        monkeypatch.setattr("dshpm_jax._control.full.refine.EVIDENCE_BYTES", limit)
        best, worth = run(refine_best([refine_labels(problem, start) for start in starts], alone[0].evidence))
        assert worth == [solution.objective for solution in alone] and best.objective == max(worth)
