"""Blocks of trajectories that share frames say what a table of all pairs would."""

import numpy as np
import pytest

from dshpm_jax._control.full import overlap
from dshpm_jax._control.full.assignment import margins
from dshpm_jax._types import NO_MATCH


def lives(rng, count: int, in_order: bool) -> tuple[np.ndarray, np.ndarray]:
    start = rng.integers(0, 1000, count)
    start = np.sort(start) if in_order else start
    return start, start + rng.integers(1, 60, count)


def table(start, stop) -> np.ndarray:
    return (start[:, None] < stop) & (start < stop[:, None]) & ~np.eye(len(start), dtype=bool)


@pytest.mark.parametrize("in_order", [True, False])
@pytest.mark.parametrize("count", [0, 1, 7, 8, 50])
def test_every_pair_once(count, in_order, monkeypatch):
    monkeypatch.setattr(overlap, "ROWS", 7)
    start, stop = lives(np.random.default_rng(count), count, in_order)
    found, rows_seen = np.zeros((count, count), int), []
    for rows, near, together in overlap.overlap_blocks(start, stop):
        found[np.ix_(rows, near)] += together
        rows_seen += rows.tolist()
    assert rows_seen == list(range(count))
    np.testing.assert_array_equal(found, table(start, stop))


def test_a_long_recording_has_small_blocks():
    rng = np.random.default_rng(0)
    start, stop = lives(rng, 5000, True)
    assert max(len(near) for _, near, _ in overlap.overlap_blocks(start * 100, start * 100 + stop - start)) < 2000


@pytest.mark.parametrize("seed", range(5))
def test_margins_are_those_of_the_best_rival(seed, monkeypatch):
    monkeypatch.setattr(overlap, "ROWS", 5)
    rng = np.random.default_rng(seed)
    start, stop = lives(rng, 40, seed % 2 == 0)
    evidence, identity = rng.normal(0, 5, (40, 6)), rng.integers(NO_MATCH, 6, 40)
    margin = margins(identity, evidence, start, stop)
    for j, shared in enumerate(table(start, stop)):
        label = identity[j]
        rivals = [*np.delete(evidence[j], label), *evidence[shared, label]]
        wanted = np.inf if label == NO_MATCH else evidence[j, label] - max(rivals)
        assert margin[j] == wanted


@pytest.mark.parametrize("in_order", [True, False])
def test_chains_are_what_a_table_connects(in_order):
    start, stop = lives(np.random.default_rng(5), 60, in_order)
    reach = table(start, stop) | np.eye(60, dtype=bool)
    for _ in range(6):
        reach = (reach.astype(int) @ reach) > 0
    found = overlap.chains(start, stop)
    assert sorted(np.concatenate(found)) == list(range(60)) and overlap.chains(start[:0], stop[:0]) == []
    assert all(group.tolist() == np.flatnonzero(reach[group[0]]).tolist() for group in found)
    assert [group[0] for group in found] == sorted(group[0] for group in found)
