"""What the distances between all labelled points of a frame say: only they tell a head that is turned back to front."""

import numpy as np
from jaxtyping import Float

from dshpm_jax._control.problem import LabellingProblem

FRAMES_AT_ONCE = 1024  # whose tables of distances are held together


def distance_llr(
    problem: LabellingProblem, places: Float[np.ndarray, "frames markers 3"]
) -> Float[np.ndarray, " frames"]:
    """Evidence in the distances between all identified markers of each frame (nats); NaN places are not identified.

    A marker has as many distances as there are others, most of them saying the same; together they count as
    `Tuning.distance_weight`. A distance that does not fit says nothing: bodies take postures that no model has seen.
    """
    parts = [places[first : first + FRAMES_AT_ONCE] for first in range(0, len(places), FRAMES_AT_ONCE)]
    prepared, half = problem.prepared, (problem.tuning.t_dof + 1) / 2
    total = [
        sum((_of_subject(part[:, own], half, *pairs) for own, *pairs in prepared.subjects), np.zeros(len(part)))
        for part in parts
    ]
    both_ways = 0.5  # each pair is counted from either end
    return np.concatenate([np.zeros(0), *total]) * (both_ways * problem.tuning.distance_weight / prepared.partners)


def _of_subject(
    places: np.ndarray, half: float, mean: np.ndarray, inverse: np.ndarray, peak: np.ndarray
) -> Float[np.ndarray, " frames"]:
    """The evidence in all distances of a subject, in frames whose tables of them fit into memory together.

    Arguments:
        places: (frames, markers, 3), mm.
        half: the exponent of the t density, half of its degrees of freedom and one.
        mean, inverse, peak: `PreparedModel.pairs` of the subject.
    """
    there = np.asarray(np.isfinite(places[..., 0])).astype(np.float32)
    places = np.nan_to_num(places)
    middle = np.einsum("fmi,fm->fi", places, there) / np.maximum(there.sum(1), 1.0)[:, None]
    places = ((places - middle[:, None]) * there[..., None]).astype(np.float32)
    square = (places**2).sum(-1)
    error = square[:, :, None] + square[:, None] - 2.0 * places @ places.transpose(0, 2, 1)
    np.sqrt(np.maximum(error, 0.0, out=error), out=error)
    error -= mean
    error *= inverse
    error *= error
    error += 1.0
    np.log(error, out=error)
    error *= -half
    error += peak
    np.maximum(error, 0.0, out=error)
    return ((error @ there[..., None])[..., 0] * there).sum(-1)
