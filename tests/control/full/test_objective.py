"""What a labelling is worth, and whether its model fits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from takes import model

from dshpm_jax import Recording, Settings, SubjectModel, label_many
from dshpm_jax._control.full.evidence import evidence_in, sample_frames
from dshpm_jax._control.full.objective import Incumbent, Solution, better_of, gain_in_frames, model_fit, share_held
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._types import NO_MATCH

POOR_FIT = TUNING.poor_fit_below


def judged(problem, labels):
    """The solution with just these labels."""
    return Solution.of(problem, labels, (yield from evidence_in(problem, labels, sample_frames(problem))))


def test_right_labels_are_worth_more_than_a_head_turned_round(problem, truth, run):
    front, back = (tuple(map(model().markers.index, names)) for names in (("LFHD", "RFHD"), ("RBHD", "LBHD")))
    turned = truth.copy()
    for a, b in zip(front, back):
        turned[truth == a], turned[truth == b] = b, a
    right, wrong = (run(judged(problem, labels)) for labels in (truth, turned))
    assert (turned != truth).sum() >= 4 and right.objective > 1.02 * wrong.objective


def test_another_body_fits_worse_whatever_is_missing(problem, truth, run):
    other = LabellingProblem(problem.trajectories, problem.model.scaled(1.2), problem.settings)
    fewer = np.where(np.arange(len(truth)) % 4 == 0, NO_MATCH, truth)
    nothing = np.full(len(truth), NO_MATCH)
    cases = (problem, truth), (problem, fewer), (other, truth), (problem, nothing)
    own, lacking, odd, empty = (model_fit(where, run(judged(where, labels))) for where, labels in cases)
    assert own > 1.1 * POOR_FIT and lacking > POOR_FIT and odd < POOR_FIT and empty == 0.0


def test_the_objective_by_a_slow_loop(problem, truth, run):
    solution, t = run(judged(problem, truth)), problem.trajectories
    frames, wanted = solution.evidence.frames, 0.0
    for j in np.flatnonzero(truth != NO_MATCH):
        inside = np.flatnonzero((t.start[j] <= frames) & (frames < t.stop[j]))
        mean = np.mean([solution.evidence.llr[f, t.slot[j], truth[j]] for f in inside])
        wanted += (mean - TUNING.accept_llr) * (t.stop[j] - t.start[j])
    wanted += solution.evidence.distance_llr.mean() * t.num_frames
    assert solution.objective == pytest.approx(wanted, rel=1e-5)


def test_the_share_held_by_a_slow_loop(problem, truth, run):
    solution = run(judged(problem, truth))
    usual = np.maximum(problem.prepared.expected_llr - TUNING.accept_llr, TUNING.min_usual_gain)
    held = 0.0
    for frame, labels in enumerate(solution.evidence.labels):
        for slot in np.flatnonzero(labels != NO_MATCH):
            held += max(solution.evidence.llr[frame, slot, labels[slot]] - TUNING.accept_llr, 0.0)
    assert share_held(problem, solution) == pytest.approx(held / len(solution.evidence.labels) / usual.sum(), rel=1e-5)
    assert gain_in_frames(problem, solution.evidence).max() > 0


def test_the_incumbent_gives_way_to_what_is_worth_more(problem):
    first, same, better = (Solution(np.zeros(1, int), np.zeros((1, 1)), worth, None) for worth in (1.0, 1.0, 2.0))  # type: ignore[arg-type]
    incumbent = Incumbent(first)
    assert not incumbent.offer(problem, None) and not incumbent.offer(problem, same) and incumbent.solution is first
    assert incumbent.offer(problem, better) and incumbent.solution is better and incumbent.objective == 2.0
    assert better_of(first, same) is first and better_of(first, better) is better


def test_a_rigid_triangle_fits_its_own_model():
    """No marker has three neighbours, so what a right label usually holds is that of distances."""
    corners = np.array([[0.0, 0, 0], [150, 0, 0], [0, 240, 0]])
    takes = [tumbling(corners, seed) for seed in (1, 2)]
    wand = SubjectModel.from_recordings(takes[:1], {"wand": list("ABC")})
    (labelling,) = label_many([replace(takes[1], labels=("*1", "*2", "*3"))], [wand], Settings(min_confidence=0.95))
    assert (labelling.identity[np.argsort(labelling.trajectories.slot)] == [0, 1, 2]).all()
    assert labelling.stats["model_fit"] > POOR_FIT


def tumbling(corners: np.ndarray, seed: int) -> Recording:
    rng, time = np.random.default_rng(seed), np.arange(120) / 60
    turned = Rotation.from_rotvec(np.stack([np.sin(time * k + rng.uniform(0, 6)) for k in (1.1, 0.7, 0.5)], 1))
    points = np.einsum("fij,mj->fmi", turned.as_matrix(), corners) + 300 * np.sin(time)[:, None, None] + 1000
    return Recording(points + rng.normal(0, 0.3, points.shape), tuple("ABC"), 60.0)
