"""`label` and `label_many`: what they promise, what they refuse, and in how many programs."""

from dataclasses import replace

import jax
import numpy as np
import pytest
from takes import METHODS, model, shares, take, take_for

from dshpm_jax import Recording
from dshpm_jax._label import label, label_many
from dshpm_jax._settings import Settings

PROGRAMS = 8  # kernels times the buckets that recordings of one size can reach
COMPILING = "/jax/core/compile/backend_compile_duration"


def test_a_model_without_neighbourhoods_is_for_the_other_methods():
    recording, bare = take(0)[0].frames(0, 20), replace(model(), neighbourhoods=())
    with pytest.raises(ValueError, match="no neighbourhoods, which the method 'full' judges by"):
        label(recording, bare)
    assert (label(recording, bare, Settings(method="paper")).identity >= 0).any()


@pytest.fixture
def compiled():
    """Names of the programs that are compiled while the test runs."""
    names = []

    def listen(event, _, **about):
        if event == COMPILING:
            names.append(about.get("fun_name"))

    jax.monitoring.register_event_duration_secs_listener(listen)
    yield names
    jax.monitoring.unregister_event_duration_listener(listen)


@pytest.mark.parametrize("method", METHODS)
def test_what_a_labelling_holds(method):
    recording = take_for(method, 3)
    found = label(recording, model(), Settings(method=method))
    assert found.recording is recording and found.model is model()
    tracks = len(found.trajectories)
    assert found.identity.shape == found.confidence.shape == (tracks,) and len(found.reason) == tracks
    assert ((found.identity >= -1) & (found.identity < 34)).all()
    assert ((found.confidence >= 0) & (found.confidence <= 1)).all()
    assert found.stats["svd_count"] > 0
    assert found.identities.shape == recording.points.shape[:2]
    assert (found.identities[~recording.present] == -1).all()


@pytest.mark.parametrize(
    ("method", "right", "wrong"), [("full", 0.97, 0.005), ("paper", 0.65, 0.2), ("static", 0.6, 0.2)]
)
def test_how_much_is_right(method, right, wrong):
    """Guards against a fall; how good the methods are is measured elsewhere."""
    rates = []
    for seed in (3, 4):
        recording, truth = take_for(method, seed), take(seed)[1]
        rates.append(shares(label(recording, model(), Settings(method=method)).identities, recording, truth))
    assert np.mean(rates, axis=0)[0] > right and np.mean(rates, axis=0)[1] < wrong


def test_ten_recordings_in_a_handful_of_programs(compiled):
    first, _ = take(20, frames=40)
    label(first, model())
    assert len(compiled) <= PROGRAMS, compiled
    compiled.clear()
    for seed in range(21, 30):
        label(take(seed, frames=40)[0], model())
    assert not compiled


@pytest.mark.parametrize(("method", "least"), [("full", 0.98), ("paper", 0.75), ("static", 0.75)])
def test_empty_frames_and_nearly_empty_recordings(method, least):
    recording, (_, truth) = take_for(method, 3), take(3)
    points = recording.points.copy()
    points[1] = np.nan
    for some in (replace(recording, points=points), replace(recording, points=recording.points[:1])):
        found = label(some, model(), Settings(method=method)).identities
        assert (found[~some.present] == -1).all()
        assert shares(found, some, truth)[0] > least


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("places", [[[1.0, 1, 1]], [[0.0, 0, 0], [100.0, 0, 0]]], ids=["one point", "two points"])
def test_points_too_few_for_a_fit_stay_unlabelled(method, places):
    few = Recording(np.tile([places], (3, 1, 1)), tuple(f"*{k}" for k in range(len(places))), 60.0)
    found = label(few, model(), Settings(method=method))
    assert found.recording.present.all() and len(found.trajectories) and (found.identities == -1).all()


def test_a_recording_without_points_is_refused():
    empty = Recording(np.full((5, 3, 3), np.nan), ("*1", "*2", "*3"), 60.0)
    with pytest.raises(ValueError, match="no point is seen"):
        label(empty, model())


def test_a_model_for_all_or_for_each():
    recordings = [take_for("paper", seed) for seed in (3, 4)]
    settings = Settings(method="paper")
    one, each = (list(label_many(recordings, models, settings)) for models in (model(), [model(), model()]))
    for a, b in zip(one, each, strict=True):
        np.testing.assert_array_equal(a.identity, b.identity)
    with pytest.raises(ValueError, match="2 recordings but 3 models"):
        list(label_many(recordings, [model()] * 3, settings))
