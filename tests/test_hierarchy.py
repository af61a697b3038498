"""Order, children and root of the tree of segments (section 4.4)."""

import numpy as np

from dshpm_jax._hierarchy import children, choose_root, depth_first
from dshpm_jax._model import Segment


def tree(parents: list[int], sizes: list[int]) -> list[Segment]:
    return [
        Segment(f"s{i}", tuple(range(size)), np.zeros((size, 3)), parent)
        for i, (parent, size) in enumerate(zip(parents, sizes))
    ]


def test_children_come_with_the_most_markers_first():
    assert children(tree([-1, 0, 0, 0], [4, 3, 5, 3]), 0) == [2, 1, 3]


def test_depth_first_goes_chain_by_chain_from_the_root():
    assert depth_first(tree([1, -1, 1, 0, 2], [3, 5, 4, 3, 3])) == [1, 2, 4, 0, 3]


def test_the_root_has_many_markers_and_many_links():
    links = [[1, 2, 3], [0], [0, 4], [0], [2]]
    assert choose_root([5, 5, 8, 3, 3], links) == 0  # a shank full of markers is no trunk
    assert choose_root([4, 4], [[1], [0]]) == 0
