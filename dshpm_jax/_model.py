"""The subject's articulated marker model on the host."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._hierarchy import Segment, VirtualJoin
from dshpm_jax._model_building import (
    POSED_SECONDS,
    Neighbourhood,
    Skeleton,
    bone_groups,
    build_neighbourhoods,
    build_segments,
    expected_spread,
    gather,
    named_frame,
    pair_statistics,
    posed_clip,
)
from dshpm_jax._recording import Recording


@dataclass(frozen=True, eq=False)
class SubjectModel:
    """Markers of one subject, how their distances behave, and the segments that they form.

    Attributes:
        markers: names; the position in this tuple is the marker's identity.
        segments: nearly rigid groups that cover all markers and may share some (section 3.1).
        pair_mean, pair_spread: mean and standard deviation of the distance of two markers (mm), NaN for a pair never
            seen together. As far as the model's recordings show little motion, or only a single frame, the spread is
            that of such markers in general (`_model_building.expectation`).
        pair_low, pair_high: smallest and largest such distance (mm).
        pair_frames: in how many frames the pair was seen together.
        neighbourhoods: for each marker those that predict its place best.
        sources: names of the recordings that it was made from.
    """

    markers: tuple[str, ...]
    segments: tuple[Segment, ...]
    pair_mean: Float[np.ndarray, "markers markers"]
    pair_spread: Float[np.ndarray, "markers markers"]
    pair_low: Float[np.ndarray, "markers markers"]
    pair_high: Float[np.ndarray, "markers markers"]
    pair_frames: Int[np.ndarray, "markers markers"]
    neighbourhoods: tuple[Neighbourhood, ...] = ()
    sources: tuple[str, ...] = field(default=())

    @property
    def num_markers(self) -> int:
        return len(self.markers)

    @classmethod
    def from_recordings(
        cls, recordings: Sequence[Recording], segments: Mapping[str, Any] | None = None, template: str | None = None
    ) -> "SubjectModel":
        """A model from labelled recordings of one subject.

        Arguments:
            recordings: one or more; columns without a name are ignored. A recording counts by how much it moves.
            segments: segment names to `{"markers": [...], "parent": ...}` or to lists of marker names; by default
                segments are found from the motion or, where there is none, from the names of the markers.
            template: take the segments from a known marker set, such as "plug-in-gait".
        """
        names, clips = gather(recordings)
        sources = tuple(recording.source.name for recording in recordings if recording.source)
        how = {"segments": segments, "template": template}
        return cls._from_clips(names, clips, [recording.rate for recording in recordings], sources, **how)

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

        One frame shows no softness, so the spreads are those of markers in general.

        Arguments:
            recording: its columns need no names.
            frame: which frame, from 0; one in which every marker is seen, in a clear pose.
            names: the number of a point (its column, see `view_frame`) to the name of its marker; points that are not
                named are left out.
            segments, template: see `from_recordings`.

        Raises:
            ValueError: there is no such frame or point, a name is wrong, or the segments are.
        """
        return cls.from_recordings([named_frame(recording, frame, names)], segments, template)

    @classmethod
    def from_skeleton(cls, skeleton: Skeleton, source: str = "") -> "SubjectModel":
        """A model from a capture system's own subject file, by poses that its joints allow.

        Arguments:
            skeleton: bones and markers, as read from the file.
            source: the file's name.
        """
        clip = posed_clip(skeleton)
        names = tuple(marker.name for marker in skeleton.markers)
        rates, sources = [len(clip) / POSED_SECONDS], (source,) if source else ()
        return cls._from_clips(names, [clip], rates, sources, rigid=bone_groups(skeleton))

    @classmethod
    def _from_clips(
        cls,
        names: tuple[str, ...],
        clips: Sequence[Float[np.ndarray, "frames markers 3"]],
        rates: Sequence[float],
        sources: tuple[str, ...],
        **segments: Any,
    ) -> "SubjectModel":
        """A model from clips of the markers; `segments` are further arguments of `build_segments`."""
        statistics = pair_statistics(clips, rates)
        return cls(
            markers=names,
            segments=build_segments(names, clips, statistics, **segments),
            pair_mean=statistics.mean,
            pair_spread=expected_spread(statistics, names),
            pair_low=statistics.low,
            pair_high=statistics.high,
            pair_frames=statistics.frames,
            neighbourhoods=build_neighbourhoods(names, clips, statistics, loose="rigid" in segments),
            sources=sources,
        )

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
            pair_low=self.pair_low * factor,
            pair_high=self.pair_high * factor,
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
    softness = np.hypot(near.softness * factor, slack)
    return replace(near, shape=shape, softness=softness, spread=float(np.hypot(near.spread * factor, further)))


def pair_tolerance(
    model: SubjectModel, spreads: float = 1.5, floor: float = 4.0, share: float = 0.015
) -> Float[np.ndarray, "markers markers"]:
    """Allowed change of each pair distance (mm), NaN where unknown.

    Arguments:
        spreads: so many learnt standard deviations,
        floor: so many mm,
        share: and such a share of the distance, added as squares (`Settings.spread_factor` and what follows it).
    """
    return np.sqrt((spreads * model.pair_spread) ** 2 + floor**2 + (share * model.pair_mean) ** 2)
