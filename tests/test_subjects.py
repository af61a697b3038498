"""Several subjects in one recording."""

from functools import cache

import numpy as np
import pytest
from making import make_model

from dshpm_jax import Driver, Recording, Settings, SubjectModel, combine_models, io, label
from dshpm_jax._control.full.evidence import evidence_in, mean_over_lives, sample_frames
from dshpm_jax._control.full.neighbourhoods.subject_swaps import swap_between_subjects
from dshpm_jax._control.full.objective import Incumbent, Solution
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._hierarchy import children, depth_first
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_PARENT
from dshpm_jax.evaluation import precision_recall_f1
from dshpm_jax.synthesis import add_ghosts, open_gaps, person, scramble

FRAMES = 60


@cache
def models() -> dict[str, SubjectModel]:
    """Two people of nearly the same size, in the same markers."""
    takes = {name: person(34, frames=300, seed=subject, subject=subject) for name, subject in (("ann", 0), ("bob", 1))}
    return {name: SubjectModel.from_recordings([take.recording]) for name, take in takes.items()}


def crossing() -> Recording:
    """The two walk their ways through each other: the middles of their bodies meet but for a hand's breadth."""
    one, other = (person(34, frames=FRAMES, seed=20 + k, subject=k).recording for k in (0, 1))
    meet = one.points[FRAMES // 2].mean(0) - other.points[FRAMES // 2].mean(0) + (100.0, 0.0, 0.0)
    labels = tuple(f"{name}:{label}" for name, r in (("ann", one), ("bob", other)) for label in r.labels)
    return Recording(np.concatenate([one.points, other.points + meet], axis=1), labels, one.rate)


def test_people_who_cross_are_not_mixed_up():
    rng = np.random.default_rng(5)
    unlabelled, truth = scramble(add_ghosts(open_gaps(crossing(), 0.1, rng), 0.1, rng), rng)
    found = label(unlabelled, models())
    right = truth.numbered_by(found.model.markers)
    assert precision_recall_f1(found.identities, right).f1 > 0.99
    both = (found.identities != -1) & (right != -1)
    assert ((found.identities // 34) == (right // 34))[both].all()


def test_an_exchanged_leg_is_given_back():
    recording, both = crossing(), combine_models(models())
    problem = LabellingProblem(from_columns(recording.points, recording.rate), both, Settings())
    column = problem.trajectories.column[problem.trajectories.start, problem.trajectories.slot]
    right = np.array([both.markers.index(name) for name in recording.labels])[column]
    leg = [both.markers.index(f"ann:{name}") for name in ("LHIP", "LTHI", "LKNE", "LTIB", "LANK", "LHEE", "LTOE")]
    wrong = np.where(np.isin(right, leg), right + 34, np.where(np.isin(right, np.add(leg, 34)), right - 34, right))

    def control():
        evidence = yield from evidence_in(problem, wrong, sample_frames(problem))
        incumbent = Incumbent(Solution(wrong, mean_over_lives(problem, evidence), -np.inf, evidence))
        yield from swap_between_subjects(problem, incumbent)
        return incumbent.solution

    np.testing.assert_array_equal(next(Driver().run([control()])).identity, right)


def test_one_of_them_alone():
    alone = person(34, frames=40, seed=21, subject=1).recording
    found = label(alone, list(models().values()))
    named = found.identities[found.identities != -1]
    assert (named >= 34).mean() > 0.99 and len(named) > 0.95 * alone.present.sum()


def test_a_combined_model(tmp_path):
    both = combine_models(models())
    assert both.markers[0].startswith("ann:") and both.markers[34].startswith("bob:")
    assert len(children(both.segments, NO_PARENT)) == 2
    assert sorted(depth_first(both.segments)) == list(range(len(both.segments)))
    assert np.isnan(both.pair_mean[:34, 34:]).all() and np.isfinite(both.pair_mean[34:, 34:]).all()
    assert all({m // 34 for m in segment.markers} in ({0}, {1}) for segment in both.segments)
    for k, near in enumerate(both.neighbourhoods):
        assert {m // 34 for m in near.markers} == {k // 34}
    io.write_model(both, tmp_path / "both.json")
    assert io.read_model(tmp_path / "both.json").markers == both.markers


def test_names_of_subjects():
    model = make_model(["A", "B"])
    assert combine_models([model, model]).markers == ("subject1:A", "subject1:B", "subject2:A", "subject2:B")
    with pytest.raises(ValueError, match="without a colon"):
        combine_models({"ann:": model})
    with pytest.raises(ValueError, match="no model"):
        combine_models([])
