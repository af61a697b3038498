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


def segmentation_matrix(window, present, max_extent, max_ratio):
    """Eqs. 1 and 2, pair by pair and frame by frame; a pair seen in fewer than 3 frames stays possible."""
    points = window.shape[1]
    found = np.zeros((points, points), dtype=bool)
    for i in range(points):
        for j in range(points):
            if i == j or not present[:, i].any() or not present[:, j].any():
                continue
            frames = np.flatnonzero(present[:, i] & present[:, j])
            distances = [np.linalg.norm(window[t, i].astype(np.float64) - window[t, j]) for t in frames]
            if len(distances) < 3:
                found[i, j] = True
                continue
            within = all(d < (1 + max_ratio) * max_extent for d in distances)
            found[i, j] = within and (max(distances) - min(distances)) / np.mean(distances) < max_ratio
    return found


def unrivalled_links(distance, ratio, margin, rounds):
    """Rounds of mutual nearest pairs that have no rival, by loops over a table of distances (inf: not allowed)."""
    distance = np.array(distance, dtype=np.float64)
    links = np.full(len(distance), NO_MATCH)
    for _ in range(rounds):
        accepted = []
        for i, row in enumerate(distance):
            j = int(row.argmin())
            column = distance[:, j]
            if not np.isfinite(row[j]) or column.argmin() != i:
                continue
            rival = min(np.delete(row, j).min(initial=np.inf), np.delete(column, i).min(initial=np.inf))
            if rival >= ratio * row[j] + margin:
                accepted.append((i, j))
        for i, j in accepted:
            links[i] = j
            distance[i], distance[:, j] = np.inf, np.inf
    return links
