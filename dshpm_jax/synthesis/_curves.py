"""Smooth curves over time, and rotations about the axes of a frame."""

import numpy as np
from jaxtyping import Float

WAVES = 6  # sinusoids in a random curve: enough not to look periodic


def smooth(
    rng: np.random.Generator, seconds: Float[np.ndarray, "frames"], hertz: float, shape: tuple[int, ...] = ()
) -> Float[np.ndarray, "frames *shape"]:
    """Random curves of unit variance with frequencies up to `hertz`, one for each place of `shape`.

    They are functions of time: a longer take, or another rate, continues the same curves.
    """
    frequency = rng.uniform(0.15, 1.0, (*shape, WAVES)) * hertz
    phase = rng.uniform(0.0, 2 * np.pi, (*shape, WAVES))
    found = np.zeros((len(seconds), *shape))
    at = seconds.reshape(-1, *(1,) * len(shape))
    for k in range(WAVES):  # a wave at a time: the memory of one curve
        found += np.cos(2 * np.pi * frequency[..., k] * at + phase[..., k])
    return found * np.sqrt(2 / WAVES)


def bump(phase: Float[np.ndarray, "frames"], centre: float, width: float) -> Float[np.ndarray, "frames"]:
    """A periodic bell over a cycle: 1 at `centre`, of standard deviation `width`, both in cycles."""
    return np.exp((np.cos(2 * np.pi * (phase - centre)) - 1) / (2 * np.pi * width) ** 2)


def integral(rate_of_change: Float[np.ndarray, "frames *k"], rate: float) -> Float[np.ndarray, "frames *k"]:
    """The running integral over time, zero in the first frame."""
    found = np.cumsum(rate_of_change, axis=0) / rate
    return found - found[:1]


def turn_about(axis: int, degrees: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch 3 3"]:
    """Right-handed rotations about axis 0, 1 or 2."""
    angle = np.deg2rad(degrees)
    found = np.zeros((*np.shape(angle), 3, 3))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    found[..., axis, axis] = 1
    found[..., j, j] = found[..., k, k] = np.cos(angle)
    found[..., k, j] = np.sin(angle)
    found[..., j, k] = -found[..., k, j]
    return found


def rotations(degrees: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3 3"]:
    """Turns about y, then about the turned x, then about the turned z, by the three `degrees` in that order."""
    about_y, about_x, about_z = np.moveaxis(degrees, -1, 0)
    return turn_about(1, about_y) @ turn_about(0, about_x) @ turn_about(2, about_z)
