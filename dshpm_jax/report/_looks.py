"""What pictures and pages have in common: colours, which way is up, and which markers are linked."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from scipy.sparse.csgraph import minimum_spanning_tree

COLOURS = (  # used in the order of the hierarchy, so that neighbours differ most
    *("#3b5bdb", "#e8590c", "#2f9e44", "#9c36b5", "#f08c00", "#1098ad", "#e03131", "#74b816"),
    *("#6741d9", "#c2255c", "#099268", "#a9742f", "#4dabf7", "#f783ac", "#5c940d", "#868e96"),
)


def upward(clouds: Sequence[Float[np.ndarray, "n 3"]]) -> Float[np.ndarray, "3"]:
    """The axis that points up, which files do not say.

    Figures are taller than wide on average, and the axes of rooms that point up have positive coordinates upwards.
    """
    extent = np.sum([np.ptp(cloud, axis=0) for cloud in clouds] or [np.array([0.0, 0.0, 1.0])], axis=0)
    return np.eye(3)[np.argmax(extent)]


def shortest_tree(distances: Float[np.ndarray, "n n"]) -> list[tuple[int, int]]:
    """The shortest links that hold together what can be; a pair at distance 0 or infinity cannot be linked."""
    links = minimum_spanning_tree(distances).tocoo()
    return [(int(i), int(j)) for i, j in zip(links.row, links.col, strict=True)]
