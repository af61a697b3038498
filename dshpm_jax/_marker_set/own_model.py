"""An ordinary model of a new subject, from what is known of their distances."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from dshpm_jax._marker_set.marker_set import MarkerSet
from dshpm_jax._marker_set.posterior import Posterior
from dshpm_jax._model import Neighbourhood, Segment, SubjectModel
from dshpm_jax._model_building.shapes import with_distances


def own_model(markers: MarkerSet, known: Posterior, sources: tuple[str, ...] = ()) -> SubjectModel:
    """The model: the typical body, each shape with the subject's distances, and softer where these are not known."""
    typical = markers.model.scaled(float(np.exp(known.size)))
    mean = np.where(np.isfinite(known.mean), np.exp(known.mean), np.nan)
    np.fill_diagonal(mean, 0.0)
    unsure = np.sqrt(known.variance) * mean
    spread = np.hypot(typical.pair_spread, unsure)
    return replace(
        typical,
        segments=tuple(_segment(one, mean, spread) for one in typical.segments),
        pair_mean=mean,
        pair_spread=spread,
        neighbourhoods=tuple(
            _neighbourhood(one, marker, mean, spread, unsure) for marker, one in enumerate(typical.neighbourhoods)
        ),
        sources=sources or typical.sources,
    )


def _shaped(
    shape: Float[np.ndarray, "markers 3"], ids: list[int], mean: np.ndarray, spread: np.ndarray
) -> Float[np.ndarray, "markers 3"]:
    some = np.ix_(ids, ids)
    return with_distances(shape, mean[some], np.maximum(spread[some], 1.0)) if len(ids) > 1 else shape


def _segment(segment: Segment, mean: np.ndarray, spread: np.ndarray) -> Segment:
    shape = _shaped(segment.shape, list(segment.markers), mean, spread)
    return replace(segment, shape=shape - shape.mean(0))


def _neighbourhood(
    near: Neighbourhood, marker: int, mean: np.ndarray, spread: np.ndarray, unsure: np.ndarray
) -> Neighbourhood:
    ids = [*near.markers, marker]
    off = np.nan_to_num(unsure[marker, list(near.markers)])
    typical = float(np.sqrt(np.mean(off**2))) if len(off) else 0.0
    return replace(
        near,
        shape=_shaped(near.shape, ids, mean, spread),
        distance_sd=np.hypot(near.distance_sd, off),
        marker_sd=float(np.hypot(near.marker_sd, typical)),
    )
