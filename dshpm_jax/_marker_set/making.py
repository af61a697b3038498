"""Marker sets from labelled recordings of several subjects, put together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from dshpm_jax._marker_set.between import Between, between_subjects
from dshpm_jax._marker_set.handedness import handed_fours
from dshpm_jax._marker_set.marker_set import MarkerSet, names_of, squares
from dshpm_jax._marker_set.oddities import odd_subjects
from dshpm_jax._marker_set.tuning import TUNING, SetTuning
from dshpm_jax._marker_set.typical import typical_model
from dshpm_jax._model_building import gather
from dshpm_jax._model_building.statistics import DistanceStatistics, pair_statistics
from dshpm_jax._recording import Recording
from dshpm_jax._types import MIN_FIT_POINTS


@dataclass(frozen=True, eq=False)
class Subject:
    """The recordings of one subject, in the markers of the set.

    Attributes:
        clips: points of each recording (mm), NaN where a marker is not seen.
        rates: frames a second of each.
        worn: which markers are seen at all.
        statistics: of all pairs.
    """

    name: str
    clips: list[Float[np.ndarray, "frames markers 3"]]
    rates: list[float]
    worn: np.ndarray
    statistics: DistanceStatistics


def marker_set_of(subjects: Mapping[str, Sequence[Recording]], tuning: SetTuning = TUNING) -> MarkerSet:
    """What `MarkerSet.from_subjects` returns."""
    if not subjects:
        raise ValueError("a marker set needs labelled recordings of at least one subject, got none")
    labelled = {name: gather(recordings) for name, recordings in subjects.items()}
    markers = _markers({name: names for name, (names, _) in labelled.items()}, tuning)
    each = [_subject(name, recordings, *labelled[name], markers) for name, recordings in subjects.items()]
    found = between_subjects([one.statistics for one in each], tuning)
    count = len(markers)
    return MarkerSet(
        markers=markers,
        subjects=tuple(subjects),
        sizes=found.sizes,
        worn=np.mean([one.worn for one in each], axis=0),
        mean_log=squares(found.mean_log, count),
        between_sd=squares(found.between_sd, count),
        within=squares(found.within, count),
        spread_log=squares(found.spread_log, count),
        spread_sd=squares(found.spread_sd, count),
        components=squares(found.components, count),
        fours=handed_fours([one.clips for one in each], squares(np.exp(found.mean_log), count), tuning),
        model=_typical(markers, each, found),
        odd=odd_subjects(markers, tuple(subjects), found, tuning),
    )


def _markers(names: Mapping[str, Sequence[str]], tuning: SetTuning) -> tuple[str, ...]:
    """The markers that enough subjects wear, in order of first appearance; refuses a subject who wears others."""
    every = dict.fromkeys(name for worn in names.values() for name in worn)
    count = {marker: sum(marker in worn for worn in names.values()) for marker in every}
    kept = tuple(m for m in every if count[m] >= max(tuning.min_worn * len(names), min(2, len(names))))
    for subject, worn in names.items():
        shared = [m for m in worn if m in kept]
        if len(shared) < MIN_FIT_POINTS:
            others = names_of([m for m in every if m not in worn])
            raise ValueError(
                f"'{subject}' shares {len(shared)} markers with the others, whose markers are {others}; give subjects "
                "with one marker set, whose markers have the same names"
            )
    return kept


def _subject(
    name: str,
    recordings: Sequence[Recording],
    names: Sequence[str],
    clips: Sequence[np.ndarray],
    markers: Sequence[str],
) -> Subject:
    place = {own: k for k, own in enumerate(names)}
    ordered = []
    for clip in clips:
        points = np.full((len(clip), len(markers), 3), np.nan)
        for k, marker in enumerate(markers):
            if marker in place:
                points[:, k] = clip[:, place[marker]]
        ordered.append(points)
    rates = [recording.rate for recording in recordings]
    worn = np.array([marker in place for marker in markers])
    return Subject(name, ordered, rates, worn, pair_statistics(ordered, rates))


def _typical(markers: tuple[str, ...], each: Sequence[Subject], found: Between):
    """The typical body, from the clips of all, each brought to size 0."""
    mean = np.exp(found.mean_log)
    known = [one.statistics for one in each]
    statistics = DistanceStatistics(
        mean=squares(mean, len(markers)),
        spread=squares(found.within * mean, len(markers)),
        evidence=np.max([one.evidence for one in known], axis=0),
        seconds=np.sum([one.seconds for one in known], axis=0),
    )
    sized = [[clip / np.exp(size) for clip in one.clips] for one, size in zip(each, found.sizes, strict=True)]
    sources = tuple(one.name for one in each)
    return typical_model(markers, sized, known, statistics, sources)
