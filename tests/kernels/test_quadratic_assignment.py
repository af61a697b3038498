"""A climb ends where no single change is better, and what it says of labels is what pairs say."""

import numpy as np
import pytest

from dshpm_jax._driver.quadratic import climbed, softened
from dshpm_jax._requests import ClimbLabels, PairTable, SoftenLabels

POINTS, MARKERS, NODES, UNLABELLED = 11, 9, 12, -0.5


def pair_table(seed: int) -> PairTable:
    rng = np.random.default_rng(seed)
    table = rng.normal(size=(MARKERS, NODES, MARKERS))
    table += table.transpose(2, 1, 0)
    np.einsum("ana->an", table)[...] = np.where(np.arange(NODES) < 8, -6.0, 0.0)
    upper = np.triu(np.ones((POINTS, POINTS)), 1)[..., None]
    node, weight = rng.integers(0, NODES, (POINTS, POINTS, 4)) * upper, rng.random((POINTS, POINTS, 4)) * upper
    node, weight = node + node.swapaxes(0, 1), weight + weight.swapaxes(0, 1)
    return PairTable(table.astype(np.float32), node.astype(int), weight.astype(np.float32), UNLABELLED)


def total(pairs: PairTable, labels: np.ndarray) -> float:
    found = UNLABELLED * float((labels < 0).sum())
    for i in range(len(labels)):
        for j in range(i):
            if labels[i] >= 0 and labels[j] >= 0:
                found += float((pairs.table[labels[i], pairs.node[i, j], labels[j]] * pairs.weight[i, j]).sum())
    return found


def starts(seed: int, count: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.stack([np.r_[rng.permutation(MARKERS), -1, -1][rng.permutation(POINTS)] for _ in range(count)])


def changes(labels: np.ndarray):
    for i in range(POINTS):
        for label in range(-1, MARKERS):
            if labels[i] != label:
                changed = labels.copy()
                changed[labels == label] = labels[i] if label >= 0 else -1
                changed[i] = label
                yield changed


def test_judging_alone_counts_every_pair_once():
    pairs, given = pair_table(0), starts(1, 5)
    found = climbed([ClimbLabels(pairs, given, 0)])[0]
    np.testing.assert_array_equal(found.labels, given)
    np.testing.assert_allclose(found.total, [total(pairs, one) for one in given], atol=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_a_climb_ends_where_no_single_change_is_better(seed):
    pairs, given = pair_table(seed), starts(seed, 4)
    found = climbed([ClimbLabels(pairs, given, 200)])[0]
    for labels, worth, start in zip(found.labels, found.total, given, strict=True):
        assert worth == pytest.approx(total(pairs, labels), abs=1e-3) and worth >= total(pairs, start)
        assert max(total(pairs, other) for other in changes(labels)) <= worth + 0.02


def test_an_answer_does_not_depend_on_who_shares_the_call():
    asked = [ClimbLabels(pair_table(seed), starts(seed, 3), 50) for seed in range(3)]
    together = climbed(asked)
    for one, found in zip(asked, together, strict=True):
        np.testing.assert_array_equal(climbed([one])[0].labels, found.labels)
        np.testing.assert_array_equal(climbed([one])[0].benefit, found.benefit)


def test_graduated_assignment_finds_what_distances_tell_clearly():
    rng = np.random.default_rng(0)
    places = rng.normal(size=(MARKERS, 3)) * 400
    distance = np.linalg.norm(places[:, None] - places[None], axis=-1)
    nodes = np.linspace(0, 2500, NODES * 8)
    table = np.clip(3 - ((nodes[:, None] - distance[:, None]) / 60) ** 2, -3, 3).astype(np.float32)
    np.einsum("ana->an", table)[...] = -6.0
    order = rng.permutation(MARKERS)
    node = np.abs(nodes - distance[np.ix_(order, order)][..., None]).argmin(-1)[..., None]
    weight = (1.0 - np.eye(MARKERS, dtype=np.float32))[..., None]
    pairs = PairTable(table, node, weight, -1.0)
    even = np.full((1, MARKERS, MARKERS), 1 / MARKERS, np.float32)
    benefit = softened([SoftenLabels(pairs, even, np.geomspace(0.02, 1, 30)[None])])[0]
    np.testing.assert_array_equal(benefit[0].argmax(1), order)
