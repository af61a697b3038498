"""A subject of whom nothing is labelled, by what others of the marker set have in common."""

import numpy as np
import pytest

from dshpm_jax import MarkerSet, Member, Recording, Settings, find_subject, label
from dshpm_jax.synthesis import person


def take(subject: int, seed: int, frames: int = 90) -> Recording:
    return person(34, frames=frames, subject=subject, seed=seed).recording


@pytest.fixture(scope="module")
def markers() -> MarkerSet:
    return MarkerSet.from_subjects({f"s{k}": [take(k, k)] for k in (1, 2, 3)})


def unnamed(given: Recording, seed: int, columns: tuple[str, ...]) -> tuple[Recording, np.ndarray]:
    """The recording without names and in another order, and the marker of each column."""
    order = np.random.default_rng(seed).permutation(given.points.shape[1])
    truth = np.array([columns.index(given.labels[k]) for k in order])
    return Recording(given.points[:, order], ("",) * len(order), given.rate), truth


def test_a_new_subject_is_labelled_and_their_model_found(markers):
    recording, truth = unnamed(take(7, 7), 0, markers.markers)
    found = label(recording, markers)
    named = found.identities != -1
    assert (found.identities == truth)[named].mean() == 1.0 and named.mean() > 0.9
    assert found.model.markers == markers.markers
    true = np.linalg.norm(np.diff(take(7, 7).points[:, :2], axis=1), axis=-1).mean()
    one, other = (markers.markers.index(name) for name in take(7, 7).labels[:2])
    assert found.model.pair_mean[one, other] == pytest.approx(true, rel=0.03)


def test_a_subject_is_found_once_from_several_recordings_in_any_order(markers):
    some = [unnamed(take(8, seed, 60), seed, markers.markers)[0] for seed in (1, 2)]
    model = find_subject(some, markers)
    np.testing.assert_allclose(find_subject(some[::-1], markers).pair_mean, model.pair_mean, rtol=1e-9)
    recording, truth = unnamed(take(8, 3, 60), 3, markers.markers)
    found = label(recording, Member(markers, model))
    named = found.identities != -1
    assert (found.identities == truth)[named].mean() == 1.0 and named.mean() > 0.9
    assert found.model is model


def test_what_a_set_cannot_do_is_said(markers):
    recording, _ = unnamed(take(7, 7, 5), 0, markers.markers)
    for settings in (Settings(method="paper"), Settings(rescale=True)):
        with pytest.raises(ValueError, match='a marker set labels with the method "full"'):
            label(recording, markers, settings)
    other = MarkerSet.from_subjects({"a": [person(49, frames=40).recording]})
    with pytest.raises(ValueError, match="has other markers than the marker set"):
        Member(markers, other.model)
