"""Intervals, the root of synthetic people, and the numbers of trials."""

import numpy as np
import pytest

from dshpm_jax._experiments.distortion import segment_length
from dshpm_jax._experiments.statistics import mean_of
from dshpm_jax._experiments.subjects import piece, rooted, synthetic
from dshpm_jax._experiments.table1 import (
    ACTIVITIES,
    AS_PUBLISHED,
    BROKEN,
    LEAST,
    MOST,
    PROTOCOLS,
    PUBLISHED,
    plan,
)
from dshpm_jax._experiments.trials import Point, generator
from dshpm_jax._types import NO_MATCH, NO_PARENT
from dshpm_jax.synthesis import distort, person


def test_intervals_cover_the_mean_as_often_as_they_say():
    rng = np.random.default_rng(0)
    inside = [low <= 0.3 <= high for _, low, high in (mean_of(rng.beta(3, 7, 40)) for _ in range(2000))]
    assert 0.92 < np.mean(inside) < 0.97


def test_intervals_stay_where_a_rate_can_be():
    assert mean_of([1.0, 1.0, 0.9], (0.0, 1.0)).high == 1.0
    assert mean_of([1.0, 1.0], (0.0, 1.0)) == (1.0, 1.0, 1.0)
    assert np.isnan(mean_of([0.5]).low)


@pytest.mark.parametrize("markers", [27, 30, 34, 49, 50])
def test_people_are_rooted_in_the_trunk(markers):
    """It has the most markers and neighbours (section 4.4); who hangs with whom does not change."""
    before = person(markers, frames=2).segments
    after = rooted(before)
    assert [name for name, entry in after.items() if entry["parent"] is None] == ["thorax"]
    pairs = [{frozenset((n, str(e["parent"]))) for n, e in s.items() if e["parent"]} for s in (before, after)]
    assert pairs[0] == pairs[1]


def test_models_have_the_parameters_of_the_paper():
    model = synthetic(30, "walking", 60, 0, 1).model
    of = {segment.name: (segment.distortion_ratio, segment.matching_quantity) for segment in model.segments}
    assert (of["head"], of["left thigh"], of["thorax"]) == ((0.05, 0.8), (0.2, 0.9), (0.1, 0.8))
    assert [s.name for s in model.segments if s.parent == NO_PARENT] == ["thorax"]


def test_distortion_changes_distances_as_the_paper_says():
    """The difference of two points has the length of half the level times the segmental length, root mean square."""
    subject = synthetic(50, "walking", 60, 0, 1)
    length = segment_length(subject.model)
    moved = distort(subject.recording, 0.2, length, np.random.default_rng(0)).points - subject.recording.points
    apart = np.sqrt(((moved[:, :1] - moved[:, 1:]) ** 2).sum(-1).mean())
    assert 100 < length < 300
    assert apart == pytest.approx(0.5 * 0.2 * length, rel=0.05)


def test_trials_have_numbers_of_their_own():
    point = Point(30, "missing", 0.1, "full")
    draw = {
        generator(seed, one, trial).random()
        for seed in (1, 2)
        for trial in (0, 1)
        for one in (point, point._replace(markers=50), point._replace(kind="extra"), point._replace(level=0.2))
    }
    assert len(draw) == 16
    assert generator(1, point, 0).random() == generator(1, point._replace(method="paper"), 0).random()


def test_pieces_of_a_recording():
    recording = person(27, frames=50).recording
    assert piece(recording, 60, np.random.default_rng(0)) is recording
    some = piece(recording, 20, np.random.default_rng(0))
    assert some.num_frames == 20
    assert (recording.points[:, 0] == some.points[0, 0]).all(-1).any()


def test_every_row_of_table_1_is_there():
    assert set(PUBLISHED) == {(markers, activity) for markers in PROTOCOLS for activity in ACTIVITIES}


@pytest.mark.parametrize(("markers", "activity"), [(27, "walking"), (34, "running"), (49, "freeform")])
def test_table_1_is_as_broken_as_the_paper_says(markers, activity):
    """As many trajectories, and as much missing and extra together; the other level breaks far more."""
    few, many = (plan(600, 1).case(Point(markers, activity, level, "full"), 0) for level in (AS_PUBLISHED, BROKEN))
    assert few.recording.points.shape[1] == pytest.approx(PUBLISHED[markers, activity].trajectories, rel=0.3)
    assert many.recording.points.shape[1] > 2 * few.recording.points.shape[1]
    for case, share in ((few, 0.5), (many, 1.0)):
        named, present = case.truth != NO_MATCH, case.recording.present
        whole = markers * case.recording.num_frames
        missing, extra = 1 - named.sum() / whole, (present & ~named).sum() / whole
        assert share * LEAST - 1e-3 <= min(missing, extra) and max(missing, extra) <= share * MOST + 1e-3
