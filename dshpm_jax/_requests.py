"""What the control asks of the kernels; plain numpy, so that control never touches jax.

Each kind of request says what it asks, which requests may share a call, and how many rigid fits its answer took.
"""

import abc
from collections.abc import Generator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._buckets import COLUMN_BUCKETS, MARKER_BUCKETS, POINT_BUCKETS, SLOT_BUCKETS, START_BUCKETS, bucket
from dshpm_jax._null_model import NullModel

T = TypeVar("T")
Answer = TypeVar("Answer")


class Request(abc.ABC, Generic[Answer]):
    """A question that the driver answers by an `Answer`."""

    @abc.abstractmethod
    def group(self) -> tuple:
        """What requests of this kind must have in common to be answered together."""

    def fits(self, answer: Answer) -> int:
        """How many rigid fits the answer took (section 5.2.3)."""
        return 0


@dataclass(frozen=True, eq=False)
class Target:
    """One segment as the matcher sees it: a column for each marker, and one for its virtual join if it has one.

    Attributes:
        segment: which segment of the model.
        markers: identity of each column, `NO_MATCH` for a virtual join.
        shape: places of the columns (mm).
        distance: distances between columns (mm).
        tolerance: allowed difference of each distance (mm, Eq. 3).
        scale: residual that Eq. 4 allows each column (mm).
        reach: how far from its predicted place a marker is still taken (mm, Fig. 3).
        need: markers that a match must hold (Eq. 5).
    """

    segment: int
    markers: Int[np.ndarray, " columns"]
    shape: Float[np.ndarray, "columns 3"]
    distance: Float[np.ndarray, "columns columns"]
    tolerance: Float[np.ndarray, "columns columns"]
    scale: Float[np.ndarray, " columns"]
    reach: Float[np.ndarray, " columns"]
    need: int


@dataclass(frozen=True, eq=False)
class SegmentMatches:
    """Every hypothesis that survived culling, in the order in which the paper would try them.

    Attributes:
        assigned: the point of each column, `NO_MATCH` where lost.
        matched: how many markers are matched (virtual joins do not count).
        error: the match score (Eq. 4); from 1 on the match is not good enough.
        accepted: whether Eqs. 4 and 5 hold.
        fits: rigid fits that the hypothesis took (section 5.2.3).
    """

    assigned: Int[np.ndarray, "hypotheses columns"]
    matched: Int[np.ndarray, " hypotheses"]
    error: Float[np.ndarray, " hypotheses"]
    accepted: Bool[np.ndarray, " hypotheses"]
    fits: Int[np.ndarray, " hypotheses"]


@dataclass(frozen=True, eq=False)
class MatchSegment(Request[SegmentMatches]):
    """Match `target` among `points` under every hypothesis (sections 4.2.1 and 4.2.2).

    Attributes:
        target: the segment.
        points: places in one frame (mm).
        free: which points may be taken.
        rigid: the segmentation matrix (Eqs. 1 and 2).
        pinned: for each column the point that it is known to be, `NO_MATCH` where it is to be found.
        pivot, assumed: the hypotheses, a column and a point each.
        banned: pairs of a column and a point that are not to be matched (section 4.3.3).
        first_acceptable: whether only the first acceptable hypothesis counts, as in the paper, which fits none of the
            later ones.
    """

    target: Target
    points: Float[np.ndarray, "points 3"]
    free: Bool[np.ndarray, " points"]
    rigid: Bool[np.ndarray, "points points"]
    pinned: Int[np.ndarray, " columns"]
    pivot: Int[np.ndarray, " hypotheses"]
    assumed: Int[np.ndarray, " hypotheses"]
    banned: tuple[tuple[int, int], ...] = ()
    first_acceptable: bool = False

    def group(self) -> tuple[int, int]:
        points = bucket(len(self.points), POINT_BUCKETS, "points")
        return points, bucket(len(self.target.markers), COLUMN_BUCKETS, "markers of a segment")

    def acceptable(self, answer: SegmentMatches) -> Int[np.ndarray, " acceptable"]:
        """The hypotheses that are accepted and match no banned pair, in the order of trying."""
        accepted = answer.accepted.copy()
        for column, point in self.banned:
            accepted &= answer.assigned[:, column] != point
        return np.flatnonzero(accepted)

    def fits(self, answer: SegmentMatches) -> int:
        tried = len(answer.fits)
        if self.first_acceptable and len(found := self.acceptable(answer)):
            tried = int(found[0]) + 1
        return int(answer.fits[:tried].sum())


@dataclass(frozen=True, eq=False)
class FittedPoses:
    """`points ~ rotation @ shape + translation` (mm); `rank` under 2 means that there is no pose."""

    rotation: Float[np.ndarray, "fits 3 3"]
    translation: Float[np.ndarray, "fits 3"]
    rms: Float[np.ndarray, " fits"]
    rank: Int[np.ndarray, " fits"]


@dataclass(frozen=True, eq=False)
class FitPoses(Request[FittedPoses]):
    """Rigid fits of `shape` to `points` with `weights`, a row each; weight 0 where there is no correspondence."""

    shape: Float[np.ndarray, "fits columns 3"]
    points: Float[np.ndarray, "fits columns 3"]
    weights: Float[np.ndarray, "fits columns"]

    def group(self) -> tuple[int]:
        return (bucket(self.shape.shape[1], COLUMN_BUCKETS, "markers of a segment"),)

    def fits(self, answer: FittedPoses) -> int:
        return len(self.shape)


@dataclass(frozen=True, eq=False)
class ScoreMatch(Request[float]):
    """The match score of one fitted hypothesis (Eq. 4), a number.

    Attributes:
        residuals: mm, 0 where nothing is matched.
        scale: residual that Eq. 4 allows each marker (mm).
        matched: which markers are.
    """

    residuals: Float[np.ndarray, " markers"]
    scale: Float[np.ndarray, " markers"]
    matched: Bool[np.ndarray, " markers"]

    def group(self) -> tuple[int]:
        return (bucket(len(self.scale), COLUMN_BUCKETS, "markers of a segment"),)


@dataclass(frozen=True, eq=False)
class Segmentation(Request[np.ndarray]):
    """The segmentation matrix of the points in a window of frames (Eqs. 1 and 2)."""

    window: Float[np.ndarray, "frames points 3"]
    max_extent: float
    max_ratio: float

    def group(self) -> tuple[()]:
        return ()


@dataclass(frozen=True, eq=False)
class LifeEvidence(Request[np.ndarray]):
    """How well every point of a frame fits a marker, from the places of the identified markers around it.

    Answered by an array (lanes, slots) of log-likelihood ratios in nats; a lane is one marker in one frame.

    Attributes:
        identified: where each marker is by what is known so far (mm), NaN where unknown.
        points: every point of those frames (mm), NaN where there is none.
        frame, marker: what each lane is about.
        neighbours: for each marker the markers that predict it, `NO_MATCH` beyond the last.
        shape, own: places of the neighbours and of the marker itself, in a frame of each neighbourhood (mm).
        distance_sd: how much the distance of each neighbour varies (mm).
        marker_sd: error of the prediction by all neighbours (mm).
        null: the densities that are compared.
    """

    identified: Float[np.ndarray, "frames markers 3"]
    points: Float[np.ndarray, "frames slots 3"]
    frame: Int[np.ndarray, " lanes"]
    marker: Int[np.ndarray, " lanes"]
    neighbours: Int[np.ndarray, "markers neighbours"]
    shape: Float[np.ndarray, "markers neighbours 3"]
    own: Float[np.ndarray, "markers 3"]
    distance_sd: Float[np.ndarray, "markers neighbours"]
    marker_sd: Float[np.ndarray, " markers"]
    null: NullModel

    def group(self) -> tuple[int, NullModel]:
        return bucket(self.points.shape[1], SLOT_BUCKETS, "points"), self.null

    def fits(self, answer: np.ndarray) -> int:
        return self.null.fits_per_place * len(self.marker)


@dataclass(frozen=True, eq=False)
class PairTable:
    """What pairs of points of one moment say of pairs of markers (nats), see `_kernels.quadratic_assignment`.

    Attributes:
        table: the score of two markers at each node.
        node, weight: the nodes of each pair of points, and how much each counts.
        unlabelled: what a point without a label scores.
    """

    table: Float[np.ndarray, "markers nodes markers"]
    node: Int[np.ndarray, "points points corners"]
    weight: Float[np.ndarray, "points points corners"]
    unlabelled: float

    def group(self) -> tuple[int, int, int]:
        points = bucket(self.node.shape[0], POINT_BUCKETS, "points")
        markers = bucket(len(self.table), MARKER_BUCKETS, "markers of a set")
        return points, markers, self.table.shape[1]


@dataclass(frozen=True, eq=False)
class ClimbedLabels:
    """Labellings that no single change betters, what each scores, and what each label says for each point (nats)."""

    labels: Int[np.ndarray, "starts points"]
    total: Float[np.ndarray, " starts"]
    benefit: Float[np.ndarray, "starts points markers"]


@dataclass(frozen=True, eq=False)
class ClimbLabels(Request[ClimbedLabels]):
    """Change one or two labels at a time for as long as that pays, at most `steps` times; with 0 only judge them."""

    pairs: PairTable
    labels: Int[np.ndarray, "starts points"]
    steps: int

    def group(self) -> tuple:
        return *self.pairs.group(), bucket(len(self.labels), START_BUCKETS, "labellings"), self.steps


@dataclass(frozen=True, eq=False)
class SoftenLabels(Request[np.ndarray]):
    """Graduated assignment from shares of labels; answered by what each label then says for each point (nats).

    Attributes:
        start: the share of each label that a point has at first.
        sharpness: how much a nat a partner counts, step by step, the same number of steps for all.
    """

    pairs: PairTable
    start: Float[np.ndarray, "starts points markers"]
    sharpness: Float[np.ndarray, "starts steps"]

    def group(self) -> tuple:
        return *self.pairs.group(), self.sharpness.shape, self.sharpness.tobytes()


@dataclass(frozen=True, eq=False)
class SignedVolumes(Request[np.ndarray]):
    """What signed volumes of labelled points say (nats), an array (labellings, fours).

    Attributes:
        points: places in some frames (mm), NaN where one is not seen.
        fours: markers whose volumes are judged, with their means and standard deviations.
        numbers: degrees of freedom, the standard deviation of the background, and the most that a four says (nats).
    """

    points: Float[np.ndarray, "frames points 3"]
    labels: Int[np.ndarray, "labellings points"]
    fours: Int[np.ndarray, "fours 4"]
    mean: Float[np.ndarray, " fours"]
    sd: Float[np.ndarray, " fours"]
    numbers: tuple[float, float, float]

    def group(self) -> tuple[()]:
        return ()


@dataclass(frozen=True, eq=False)
class Gather:
    """Run several controls side by side, so that their requests share batches; the answer is a list of theirs."""

    controls: "tuple[Control[Any], ...]"


@dataclass(frozen=True, eq=False)
class CountFits:
    """How many rigid fits this control, and all that it runs and that run it, took so far; the answer is a number."""


Control = Generator["Request[Any] | Gather | CountFits", Any, T]
"""A control: yields requests, is sent their answers, returns a T."""
