"""A rigid body in motion, for tests of fits and shapes."""

import numpy as np


def moving(seed: int, markers: int = 5, frames: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """A rigid body in random poses: its places and its points (mm)."""
    rng = np.random.default_rng(seed)
    body = rng.normal(scale=80, size=(markers, 3))
    rotation, _ = np.linalg.qr(rng.normal(size=(frames, 3, 3)))
    rotation *= np.linalg.det(rotation)[:, None, None]
    return body, np.einsum("fij,mj->fmi", rotation, body) + rng.normal(scale=500, size=(frames, 1, 3))
