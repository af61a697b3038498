"""A marker set says what its subjects have in common, and names those who differ."""

from dataclasses import replace

import numpy as np
import pytest
from subjects import marker_set, recording

from dshpm_jax import MarkerSet, Recording


def without(given: Recording, *names: str) -> Recording:
    keep = [k for k, name in enumerate(given.labels) if name not in names]
    return Recording(given.points[:, keep], tuple(given.labels[k] for k in keep), given.rate)


def test_sizes_are_told_from_proportions():
    one = recording(1)
    larger = Recording(1.1 * one.points, one.labels, one.rate)
    found = MarkerSet.from_subjects({"small": [one], "large": [larger]})
    assert found.sizes[1] - found.sizes[0] == pytest.approx(np.log(1.1), abs=1e-6)
    off = ~np.eye(found.num_markers, dtype=bool)
    assert found.between_sd[off].max() < 0.02  # they differ in nothing but size


def test_tables_are_of_all_pairs_and_symmetric():
    found = marker_set()
    for table in (found.mean_log, found.between_sd, found.within, found.spread_log):
        np.testing.assert_array_equal(table, table.T)
    assert found.markers == recording(1).labels and found.worn.tolist() == [1.0] * found.num_markers
    assert len(found.components) == len(found.subjects) - 1


def test_fours_keep_their_sign_and_a_mirror_image_changes_it():
    points = recording(9, seed=9).points
    for four in marker_set().fours[::20]:
        first, *others = (points[:, m] for m in four.markers)
        volume = np.linalg.det(np.stack([other - first for other in others], axis=1))
        assert (np.sign(volume) == np.sign(four.mean)).mean() > 0.9


def test_a_marker_that_some_lack_is_part_of_the_set():
    lacking = without(recording(2, seed=2), "LKNE")
    found = MarkerSet.from_subjects({"a": [recording(1)], "b": [lacking], "c": [recording(3, seed=3)]})
    assert found.worn[found.markers.index("LKNE")] == pytest.approx(2 / 3)
    assert np.isfinite(found.mean_log).all()


def test_a_marker_of_one_subject_alone_is_left_out():
    labels = tuple(name if name != "LKNE" else "typo" for name in recording(2, seed=2).labels)
    other = replace(recording(2, seed=2), labels=labels)
    found = MarkerSet.from_subjects({"a": [recording(1)], "b": [other], "c": [recording(3, seed=3)]})
    assert "typo" not in found.markers and "LKNE" in found.markers


def test_a_subject_whose_marker_sits_otherwise_is_named():
    moved = recording(4, seed=4).points.copy()
    shank = recording(4).labels.index("LTIB"), recording(4).labels.index("LANK")
    moved[:, shank[0]] = 0.2 * moved[:, shank[0]] + 0.8 * moved[:, shank[1]]
    odd = Recording(moved, recording(4).labels, recording(4).rate)
    given = {f"s{k}": [recording(k, seed=k)] for k in (1, 2, 3)} | {"odd": [odd]}
    found = MarkerSet.from_subjects(given)
    assert "LTIB" in next(one.markers for one in found.odd if one.subject == "odd")


def test_other_names_are_refused():
    other = replace(recording(2), labels=tuple(f"x{name}y" for name in recording(2).labels))
    with pytest.raises(ValueError, match="'b' shares 0 markers with the others"):
        MarkerSet.from_subjects({"a": [recording(1)], "c": [recording(3)], "b": [other]})
    with pytest.raises(ValueError, match="at least one subject"):
        MarkerSet.from_subjects({})
