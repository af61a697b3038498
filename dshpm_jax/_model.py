"""The subject's articulated marker model on the host: data, which `_model_building` makes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._recording import Recording
from dshpm_jax._types import NO_PARENT

if TYPE_CHECKING:
    from dshpm_jax._model_building import Skeleton

MAX_NEIGHBOURS = 8
"""count; neighbours of a marker at most, in models, their files and the arrays of the kernels; by hand: more average
out more noise, but the eighth is already on the next limb."""

SHOWN_SOURCES = 3
"""count; recordings that the line about a model names; more are counted."""


@dataclass(frozen=True, eq=False)
class VirtualJoin:
    """The centre of the joint between a segment and its parent, a point that nobody sees.

    Attributes:
        in_parent: its place in the frame of the parent's `shape` (mm).
        in_segment: its place in the frame of the segment's own `shape` (mm).
        spread: root mean square distance of the two places over the model's recordings (mm).
    """

    in_parent: Float[np.ndarray, "3"]
    in_segment: Float[np.ndarray, "3"]
    spread: float


@dataclass(frozen=True, eq=False)
class Segment:
    """A nearly rigid group of markers, P_s of the paper.

    Attributes:
        name: what people call it.
        markers: identities, ascending; a marker may belong to several segments (then it is a join point).
        shape: mean places of the markers in a frame of the segment's own, centred (mm), a row for each of `markers`.
        parent: the segment it hangs from, `NO_PARENT` for the root.
        join: identities shared with the parent, may be empty.
        virtual_join: centre of the joint with the parent, where the model's recordings show one.
        distortion_ratio: allowed relative change of a pair distance (Eqs. 1 to 4), no unit.
        matching_quantity: share of the markers that a match must hold (Eq. 5), no unit.
    """

    name: str
    markers: tuple[int, ...]
    shape: Float[np.ndarray, "segment_markers 3"]
    parent: int = NO_PARENT
    join: tuple[int, ...] = ()
    virtual_join: VirtualJoin | None = None
    distortion_ratio: float = 0.1
    matching_quantity: float = 0.8


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """The markers nearest to rigid with one marker.

    Attributes:
        markers: identities of the neighbours, in the order of `distance_sd`.
        shape: mean places of the neighbours and, last, of the marker itself, in a frame of their own (mm).
        distance_sd: standard deviation of the distance of each neighbour to the marker (mm), least first.
        marker_sd: root mean square error with which the neighbours predicted the marker in the model's recordings (mm).
    """

    markers: tuple[int, ...]
    shape: Float[np.ndarray, "neighbours+1 3"]
    distance_sd: Float[np.ndarray, " neighbours"]
    marker_sd: float


@dataclass(frozen=True, eq=False)
class SubjectModel:
    """Markers of one subject, how their distances behave, and the segments that they form.

    Attributes:
        markers: names; the position in this tuple is the marker's identity.
        segments: nearly rigid groups that cover all markers and may share some (section 3.1).
        pair_mean, pair_spread: mean and standard deviation of the distance of two markers (mm), NaN for a pair never
            seen together. As far as the model's recordings show little motion, or only a single frame, the spread is
            that of such markers in general (`_model_building.expectation`).
        neighbourhoods: for each marker those that predict its place best.
        sources: names of the recordings that it was made from.
    """

    markers: tuple[str, ...]
    segments: tuple[Segment, ...]
    pair_mean: Float[np.ndarray, "markers markers"]
    pair_spread: Float[np.ndarray, "markers markers"]
    neighbourhoods: tuple[Neighbourhood, ...] = ()
    sources: tuple[str, ...] = field(default=())

    def __repr__(self) -> str:
        sources = self.sources if len(self.sources) <= SHOWN_SOURCES else (f"{len(self.sources)} recordings",)
        made_of = f", from {' and '.join(sources)}" if sources else ""
        return f"SubjectModel({self.num_markers} markers in {len(self.segments)} segments{made_of})"

    @property
    def num_markers(self) -> int:
        return len(self.markers)

    @classmethod
    def from_recordings(
        cls,
        recordings: Recording | str | Path | Iterable[Recording | str | Path],
        segments: Mapping[str, Any] | None = None,
        template: str | None = None,
    ) -> "SubjectModel":
        """A model from labelled recordings of one subject.

        Arguments:
            recordings: one or more, or their files; columns without a name are ignored. A recording counts by how much
                it moves.
            segments: segment names to `{"markers": [...], "parent": ...}` or to lists of marker names; by default
                segments are found from the motion or, where there is none, from the names of the markers.
            template: take the segments from a known marker set, such as "plug-in-gait".

        Raises:
            ReadError: a file cannot be read.
            ValueError: no column has a name, two of one name are seen together, or the segments are wrong.
        """
        from dshpm_jax._given import recordings_of
        from dshpm_jax._model_building import model_from_recordings

        return model_from_recordings(recordings_of(recordings), segments, template)

    @classmethod
    def from_frame(
        cls,
        recording: Recording,
        frame: int,
        names: Mapping[int, str],
        segments: Mapping[str, Any] | None = None,
        template: str | None = None,
    ) -> "SubjectModel":
        """A model from one frame of an unlabelled recording, as in the paper (section 5.1.1).

        One frame shows no motion, so the spreads are those of markers in general.

        Arguments:
            recording: its columns need no names.
            frame: which frame, from 0; one in which every marker is seen, in a clear pose.
            names: the number of a point (its column, see `view_frame`) to the name of its marker; points that are not
                named are left out.
            segments, template: see `from_recordings`.

        Raises:
            ValueError: there is no such frame or point, a name is wrong, or the segments are.
        """
        from dshpm_jax._model_building import named_frame

        return cls.from_recordings([named_frame(recording, frame, names)], segments, template)

    @classmethod
    def from_skeleton(cls, skeleton: "Skeleton", source: str = "") -> "SubjectModel":
        """A model from a capture system's own subject file, by poses that its joints allow.

        Arguments:
            skeleton: bones and markers, as read from the file.
            source: the file's name.
        """
        from dshpm_jax._model_building import model_from_skeleton

        return model_from_skeleton(skeleton, source)

    def scaled(self, factor: float, proportions: float = 0.0) -> "SubjectModel":
        """The model of a body so many times as large, whose proportions may differ.

        Arguments:
            factor: on all lengths.
            proportions: share of every distance by which it may differ on top; spreads grow by it.
        """
        mean = self.pair_mean * factor
        return replace(
            self,
            segments=tuple(_scaled_segment(segment, factor) for segment in self.segments),
            pair_mean=mean,
            pair_spread=np.hypot(self.pair_spread * factor, proportions * mean),
            neighbourhoods=tuple(_scaled_neighbourhood(near, factor, proportions) for near in self.neighbourhoods),
        )


def _scaled_segment(segment: Segment, factor: float) -> Segment:
    join = segment.virtual_join
    if join is not None:
        join = VirtualJoin(join.in_parent * factor, join.in_segment * factor, join.spread * factor)
    return replace(segment, shape=segment.shape * factor, virtual_join=join)


def _scaled_neighbourhood(near: Neighbourhood, factor: float, proportions: float) -> Neighbourhood:
    shape = near.shape * factor
    slack = proportions * np.linalg.norm(shape[:-1] - shape[-1], axis=1)
    further = float(np.sqrt(np.mean(slack**2))) if len(slack) else 0.0
    marker_sd = float(np.hypot(near.marker_sd * factor, further))
    return replace(near, shape=shape, distance_sd=np.hypot(near.distance_sd * factor, slack), marker_sd=marker_sd)


def pair_tolerance(
    model: SubjectModel, spreads: float, floor: float, share: float
) -> Float[np.ndarray, "markers markers"]:
    """Allowed change of each pair distance (mm), NaN where unknown.

    Arguments:
        spreads: this number of learnt standard deviations (`Settings.spread_factor`),
        floor: this length (mm, `Settings.tolerance_floor`),
        share: and this share of the distance (`Settings.tolerance_ratio`), added as squares.
    """
    return np.sqrt((spreads * model.pair_spread) ** 2 + floor**2 + (share * model.pair_mean) ** 2)


def neighbourhood_arrays(
    neighbourhoods: Sequence[Neighbourhood],
) -> tuple[Int[np.ndarray, "markers neighbours"], ...]:
    """Neighbours (`-1` beyond the last), their places, the markers' own, `distance_sd` and `marker_sd`, all padded."""
    count = len(neighbourhoods)
    ids = np.full((count, MAX_NEIGHBOURS), -1, np.int32)
    shape = np.zeros((count, MAX_NEIGHBOURS, 3), np.float32)
    own = np.zeros((count, 3), np.float32)
    distance_sd = np.ones((count, MAX_NEIGHBOURS), np.float32)
    marker_sd = np.ones(count, np.float32)
    for m, found in enumerate(neighbourhoods):
        size = len(found.markers)
        ids[m, :size], shape[m, :size], own[m] = found.markers, found.shape[:-1], found.shape[-1]
        distance_sd[m, :size], marker_sd[m] = found.distance_sd, found.marker_sd
    return ids, shape, own, distance_sd, marker_sd
