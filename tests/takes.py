"""Short takes of one synthetic person without names, and their truth, made once for all tests that label them."""

from functools import cache

import numpy as np

from dshpm_jax import Recording, SubjectModel
from dshpm_jax.synthesis import Truth, add_ghosts, open_gaps, person, scramble

METHODS = ("full", "paper", "static")


@cache
def model() -> SubjectModel:
    return SubjectModel.from_recordings([person(34, frames=300, seed=1).recording])


@cache
def take(seed: int, frames: int = 60, gaps: float = 0.1, ghosts: float = 0.1) -> tuple[Recording, Truth]:
    rng = np.random.default_rng(seed)
    recording = open_gaps(person(34, frames=frames, seed=100 + seed).recording, gaps, rng)
    return scramble(add_ghosts(recording, ghosts, rng), rng)


def take_for(method: str, seed: int) -> Recording:
    """A take as short as `method` needs it; the static method looks at every frame alone."""
    recording, _ = take(seed)
    return recording.frames(0, 3) if method == "static" else recording


def shares(identities: np.ndarray, recording: Recording, truth: Truth) -> tuple[float, float]:
    """Shares of the points that are labelled rightly (ghosts: left out) and wrongly."""
    right = truth.numbered_by(model().markers)[: recording.num_frames]
    seen = recording.present
    wrong = (identities != right) & (identities != -1)
    return float((identities == right)[seen].mean()), float(wrong[seen].mean())
