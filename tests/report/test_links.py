"""Sticks between markers, and which are left and right."""

import numpy as np

from dshpm_jax.report._links import Part, links_of
from dshpm_jax.report._sides import sides
from dshpm_jax.synthesis import person


def test_the_head_is_linked_to_the_trunk():
    made = person(34, "walking", 120).recording
    names, points = [name for name in made.labels], made.points
    head = tuple(k for k, name in enumerate(names) if name.endswith("HD"))
    trunk = tuple(names.index(name) for name in ("C7", "CLAV", "T10"))
    foot = tuple(names.index(name) for name in ("LHEE", "LTOE"))
    links = links_of(points, [Part("trunk", trunk), Part("head", head), Part("foot", foot)], names)
    ((i, j, part),) = [link for link in links if (link[0] in head) != (link[1] in head)]
    assert part == 1 and {i, j} & {*trunk}
    assert len(links) == len(head) - 1 + len(trunk) - 1 + len(foot) - 1 + 1  # nothing near the foot


def test_subjects_are_not_linked():
    in_a_row = 100.0 * np.arange(6)[:, None] * np.array([1.0, 0.0, 0.0])
    points = in_a_row + np.random.default_rng(0).normal(0, 0.1, (50, 6, 3))
    parts = [Part("a", (0, 1)), Part("b", (2, 3)), Part("c", (4, 5))]
    assert len(links_of(points, parts, list("ABCDEF"))) == 5
    assert len(links_of(points, parts, ["x:A", "x:B", "x:C", "x:D", "y:E", "y:F"])) == 4


def test_sides_by_name():
    names = ["LKNE", "RKNE", "C7", "Left Toe", "right toe", "Hand_L1", "Hand_R1", "LONE", "l", "r"]
    assert sides(names) == [[0, 1], [3, 4], [5, 6]]
    assert sides(["ann:LKNE", "ann:RKNE", "ben:LKNE", "ben:RKNE"]) == [[0, 1]]
