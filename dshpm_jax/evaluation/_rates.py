"""How much of a labelling is right.

Two quantities of the paper share a name there and are kept apart here: the share of *points* (section 5.2.1) and the
share of *trajectories* (section 5.1.3). All functions compare two arrays of identities, the given and the true, a row
a frame and a column a point, in which `NO_MATCH` stands for no label and for no marker.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Int

from dshpm_jax._types import NO_MATCH

RIGHT_SHARE = 0.95  # of its points that must be right in a trajectory that is


class Scores(NamedTuple):
    """Counts of points and what follows from them.

    Attributes:
        right: points with the right label. given: points with any label. true: points that are a marker.
    """

    right: int
    given: int
    true: int

    @property
    def precision(self) -> float:
        """Share of the given labels that are right; NaN if none was given."""
        return self.right / self.given if self.given else float("nan")

    @property
    def recall(self) -> float:
        """Share of the markers' points that got their label; NaN if there are none."""
        return self.right / self.true if self.true else float("nan")

    @property
    def f1(self) -> float:
        """The harmonic mean of both; NaN if there is neither a label nor a marker."""
        return 2 * self.right / (self.given + self.true) if self.given + self.true else float("nan")


def point_identification_rate(
    given: Int[np.ndarray, "frames points"], truth: Int[np.ndarray, "frames points"]
) -> float:
    """The share of the markers' points that carry the right label (section 5.2.1); a ghost counts on neither side.

    Arguments:
        given, truth: identities as described above, both of one shape; a `ValueError` says if they are not.
    """
    return precision_recall_f1(given, truth).recall


def trajectory_identification_rate(
    given: Int[np.ndarray, "frames points"], truth: Int[np.ndarray, "frames points"], share: float = RIGHT_SHARE
) -> float:
    """The share of the markers' trajectories that are identified (section 5.1.3), NaN if there are none.

    Our reading: a trajectory is a marker's unbroken run of frames, in whatever columns it stands; it is identified if
    at least `share` of its points carry the right label. Ghosts are no trajectories of markers and do not count; labels
    given to them show in the precision.

    Arguments:
        given, truth: identities as described above, both of one shape; a `ValueError` says if they are not.
        share: of a trajectory's points, 0 to 1.
    """
    _check(given, truth)
    seen, right = _by_marker(given, truth)
    # a run begins where the frame before, or the end of another marker's column, is empty
    begins = seen & ~np.vstack([np.zeros_like(seen[:1]), seen[:-1]])
    run = np.cumsum(begins.T.ravel()) - 1
    seen, right = seen.T.ravel(), right.T.ravel()
    if not seen.any():
        return float("nan")
    length = np.bincount(run[seen])
    return float((np.bincount(run[seen], weights=right[seen]) >= share * length).mean())


def precision_recall_f1(given: Int[np.ndarray, "frames points"], truth: Int[np.ndarray, "frames points"]) -> Scores:
    """Scores over all points; a label on a ghost is given and not right.

    Arguments:
        given, truth: identities as described above, both of one shape; a `ValueError` says if they are not.
    """
    _check(given, truth)
    named, marker = given != NO_MATCH, truth != NO_MATCH
    return Scores(int((named & (given == truth)).sum()), int(named.sum()), int(marker.sum()))


def scores_by_label(
    given: Int[np.ndarray, "frames points"], truth: Int[np.ndarray, "frames points"], labels: Sequence[str]
) -> dict[str, Scores]:
    """Scores of each label.

    Arguments:
        given, truth: identities as described above, both of one shape; a `ValueError` says if they are not.
        labels: their places are the identities; the result is in their order.
    """
    _check(given, truth)
    return {
        label: Scores(int(((given == k) & (truth == k)).sum()), int((given == k).sum()), int((truth == k).sum()))
        for k, label in enumerate(labels)
    }


def _by_marker(given, truth) -> tuple[Bool[np.ndarray, "frames markers"], Bool[np.ndarray, "frames markers"]]:
    """Where each marker was seen, and where it got the right label; a column for each marker."""
    frame, point = np.nonzero(truth != NO_MATCH)
    marker = truth[frame, point]
    seen = np.zeros((len(truth), int(marker.max(initial=NO_MATCH)) + 1), dtype=bool)
    right = np.zeros_like(seen)
    seen[frame, marker] = True
    right[frame, marker] = given[frame, point] == marker
    return seen, right


def _check(given, truth) -> None:
    if np.shape(given) != np.shape(truth) or np.ndim(given) != 2:
        raise ValueError(
            f"given identities have the shape {np.shape(given)} and true ones {np.shape(truth)}: "
            "both must be (frames, points) of the same recording"
        )
