"""Slow, obvious numpy versions of the kernels, to compare them with."""

import numpy as np

NO_MATCH = -1


def rigid_fit(model, data, weights):
    """Rotation, translation and weighted RMS of one least-squares fit, by a float64 SVD."""
    model, data, weights = (np.asarray(x, dtype=np.float64) for x in (model, data, weights))
    model, data, weights = model[weights > 0], data[weights > 0], weights[weights > 0]
    if not len(weights):
        return np.eye(3), np.zeros(3), 0.0
    share = weights / weights.sum()
    model_mean, data_mean = share @ model, share @ data
    covariance = sum(w * np.outer(d - data_mean, m - model_mean) for w, d, m in zip(share, data, model))
    u, _, vt = np.linalg.svd(covariance)
    rotation = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    translation = data_mean - rotation @ model_mean
    return rotation, translation, fit_rms(rotation, translation, model, data, weights)


def fit_rms(rotation, translation, model, data, weights):
    """Weighted RMS distance of `data` from the moved `model`, whatever the weightless points hold."""
    rotation, translation, model, data, weights = (
        np.asarray(x, dtype=np.float64) for x in (rotation, translation, model, data, weights)
    )
    used = weights > 0
    square = ((data[used] - model[used] @ rotation.T - translation) ** 2).sum(-1)
    return float(np.sqrt((weights[used] @ square) / weights[used].sum())) if used.any() else 0.0
