"""What labels show of a subject draws the distances that are expected of them."""

import numpy as np
from subjects import marker_set, recording

from dshpm_jax._marker_set.own_model import own_model
from dshpm_jax._marker_set.posterior import posterior_of, posterior_of_model, prior_of
from dshpm_jax._model_building.statistics import pair_statistics


def observed(subject: int) -> np.ndarray:
    given = recording(subject, seed=subject)
    mean = pair_statistics([given.points], [given.rate]).mean
    np.fill_diagonal(mean, 1.0)
    return np.log(mean)


def test_size_is_found_from_some_pairs_and_told_of_the_others():
    found, shift = marker_set(), 0.08
    value = found.mean_log + shift
    value[:, found.num_markers // 2 :] = np.nan
    value[found.num_markers // 2 :] = np.nan
    known = posterior_of(found, value)
    assert 0.5 * shift < known.size < 1.2 * shift
    unseen = known.mean[-5:, -5:] - found.mean_log[-5:, -5:]
    assert unseen[~np.eye(5, dtype=bool)].min() > 0.3 * shift


def test_observed_pairs_come_nearer_and_are_surer():
    found, own = marker_set(), observed(8)
    known, prior = posterior_of(found, own), prior_of(found)
    off = ~np.eye(found.num_markers, dtype=bool)
    rigid = off & (found.within < np.quantile(found.within[off], 0.3))
    assert np.abs(known.mean - own)[rigid].mean() < 0.65 * np.abs(prior.mean - own)[rigid].mean()
    assert np.abs(known.mean - own)[off].mean() < np.abs(prior.mean - own)[off].mean()
    assert (known.variance < prior.variance)[off].mean() > 0.9


def test_an_own_model_has_the_subjects_distances_and_is_found_again():
    found, own = marker_set(), observed(8)
    known = posterior_of(found, own)
    model = own_model(found, known, ("walk.c3d",))
    np.testing.assert_allclose(model.pair_mean, model.pair_mean.T)
    off = ~np.eye(found.num_markers, dtype=bool)
    np.testing.assert_allclose(np.log(model.pair_mean[off]), known.mean[off])
    again = posterior_of_model(found, model)
    assert np.abs(again.mean - known.mean)[off].mean() < 0.02
    assert model.sources == ("walk.c3d",)
