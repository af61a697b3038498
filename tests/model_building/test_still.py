"""A model from one frame whose points a person named by their numbers."""

import numpy as np
import pytest

from dshpm_jax import Recording, SubjectModel
from dshpm_jax.synthesis import person, scramble

SEGMENTS = {"base": ["A", "B", "C"], "arm": {"markers": ["C", "D", "E"], "parent": "base"}}


@pytest.fixture
def recording() -> Recording:
    """Six points without names, of which number 2 is not seen in frame 1."""
    points = np.random.default_rng(0).uniform(0, 500, (3, 6, 3))
    points[1, 2] = np.nan
    return Recording(points, tuple(f"*{k}" for k in range(6)), 100.0)


def test_distances_are_those_of_the_frame(recording):
    names = {5: "A", 0: "B", 3: "C", 1: "D", 4: "E"}
    model = SubjectModel.from_frame(recording, 1, names, SEGMENTS)
    assert sorted(model.markers) == list("ABCDE")
    place = {name: recording.points[1, number] for number, name in names.items()}
    for i, one in enumerate(model.markers):
        for j, other in enumerate(model.markers):
            assert model.pair_mean[i, j] == pytest.approx(np.linalg.norm(place[one] - place[other]))
    assert (model.pair_spread[~np.eye(5, dtype=bool)] > 1).all()
    arm = next(segment for segment in model.segments if segment.name == "arm")
    assert [model.markers[m] for m in arm.join] == ["C"] and model.segments[arm.parent].name == "base"


@pytest.mark.parametrize(
    "frame, names, wrong",
    [
        (3, {0: "A"}, "the recording has frames 0 to 2"),
        (-1, {0: "A"}, "the recording has frames 0 to 2"),
        (1, {2: "A"}, r"does not show the points \[2\]; it shows \[0, 1, 3, 4, 5\]"),
        (1, {6: "A", -1: "B"}, r"does not show the points \[-1, 6\]"),
        (0, {0: "A", 1: "A"}, "several points are called A"),
        (0, {0: "*7", 1: ""}, r"the points \[0, 1\] have names"),
    ],
)
def test_wrong_names(recording, frame, names, wrong):
    with pytest.raises(ValueError, match=wrong):
        SubjectModel.from_frame(recording, frame, names, {"all": list(names.values())})


def test_it_is_the_model_of_the_labelled_frame():
    take = person(34, "walking", 30, seed=1).recording
    bare, truth = scramble(take, np.random.default_rng(0))
    names = {point: truth.names[who] for point, who in enumerate(truth.identities[4].tolist()) if who != -1}
    found = SubjectModel.from_frame(bare, 4, names, template="body-parts")
    expected = SubjectModel.from_recordings([take.frames(4, 5)], template="body-parts")
    order = [found.markers.index(name) for name in expected.markers]
    np.testing.assert_allclose(found.pair_mean[np.ix_(order, order)], expected.pair_mean)
    assert {s.name for s in found.segments} == {s.name for s in expected.segments}
