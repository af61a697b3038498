"""Another subject's model: of other size, of other proportions, and made to fit."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from dshpm_jax import Recording, Settings, SubjectModel, combine_models, label
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._control.uses.population import refitted
from dshpm_jax._trajectories import from_columns
from dshpm_jax.evaluation import precision_recall_f1
from dshpm_jax.synthesis import open_gaps, person, scramble


@cache
def model() -> SubjectModel:
    return SubjectModel.from_recordings([person(34, frames=300, seed=1).recording])


def test_a_scaled_model_is_that_of_a_scaled_recording():
    take = person(34, frames=300, seed=1).recording
    larger = SubjectModel.from_recordings([Recording(1.2 * take.points, take.labels, take.rate)])
    scaled = model().scaled(1.2)
    np.testing.assert_allclose(scaled.pair_mean, larger.pair_mean, rtol=1e-9)
    for one, other in zip(scaled.segments, larger.segments):
        assert one.markers == other.markers
        np.testing.assert_allclose(one.shape, other.shape, atol=1e-6)


def test_proportions_make_spreads_and_not_places():
    scaled = model().scaled(1.0, 0.04)
    np.testing.assert_array_equal(scaled.pair_mean, model().pair_mean)
    off_diagonal = ~np.eye(scaled.num_markers, dtype=bool)
    assert (scaled.pair_spread > model().pair_spread)[off_diagonal].all()
    assert all(new.marker_sd > old.marker_sd for new, old in zip(scaled.neighbourhoods, model().neighbourhoods))


def test_a_model_is_made_anew_from_what_it_labelled():
    other = person(34, frames=120, seed=4, subject=3).recording
    points = other.points.copy()
    points[TUNING.min_refit_frames - 1 :, 5] = np.nan  # seen too rarely to be placed by its own
    tracks = from_columns(points, other.rate)
    identity = np.array(
        [
            model().markers.index(other.labels[tracks.column[tracks.start[j], tracks.slot[j]]])
            for j in range(len(tracks))
        ]
    )
    made = refitted(model().scaled(0.97), tracks, identity, TUNING.min_refit_frames)
    assert made.markers == model().markers
    assert [s.markers for s in made.segments] == [s.markers for s in model().segments]
    true = SubjectModel.from_recordings([other])
    order = [true.markers.index(name) for name in made.markers]
    error = np.abs(made.pair_mean - true.pair_mean[np.ix_(order, order)])
    rare = made.markers.index(other.labels[5])
    assert np.delete(np.delete(error, rare, 0), rare, 1).max() < 1e-6
    assert np.median(error[rare]) < 30


@pytest.mark.slow
def test_somebody_elses_recording_is_labelled_once_the_model_is_rescaled():
    tuning = replace(TUNING, sizes=(0.82, 1.12, 4))  # to be done sooner
    rng = np.random.default_rng(2)
    taller = person(34, frames=60, seed=7, subject=5).recording
    other = open_gaps(Recording(1.1 * taller.points, taller.labels, taller.rate), 0.05, rng)
    unlabelled, truth = scramble(other, rng)
    right = truth.numbered_by(model().markers)
    plain, rescaled = (
        label(unlabelled, model(), settings, tuning=tuning) for settings in (Settings(), Settings(rescale=True))
    )
    rates = [precision_recall_f1(found.identities, right) for found in (plain, rescaled)]
    assert rates[1].f1 > 0.99 and rates[1].f1 > rates[0].f1
    assert rescaled.confidence[rescaled.identity >= 0].max() <= TUNING.rescaled_share


def test_only_one_subject_is_rescaled_and_only_by_the_full_method():
    with pytest.raises(ValueError, match="one subject at a time"):
        label(person(34, frames=20).recording, combine_models([model(), model()]), Settings(rescale=True))
    with pytest.raises(ValueError, match="rescales"):
        Settings(method="paper", rescale=True)
