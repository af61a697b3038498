"""`correct`: what follows from a person's labels, at once."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._control.uses.correcting import corrected
from dshpm_jax._driver import Driver
from dshpm_jax._known import KnownLabel, known_points
from dshpm_jax._label import labelling_of
from dshpm_jax._labelling import WITHHELD, Labelling
from dshpm_jax._settings import Settings


def correct(
    labelling: Labelling,
    known: Sequence[KnownLabel],
    settings: Settings | None = None,
    driver: Driver | None = None,
    tuning: Tuning = TUNING,
) -> Labelling:
    """Labels a recording anew around labels that are known, starting from those that it has.

    This is much faster than `label(recording, model, known=...)`, as nothing is searched for: what the known labels
    leave room for stays unless the evidence is against it now. What it gives depends on the labels before; `label` is
    what a result is made with.

    Arguments:
        labelling: of the full method, or read from a result (`io.read_labelling`).
        known: all labels that are known, also those that were known before.
        settings, driver, tuning: as for `label`; the method is the full one.

    Raises:
        ValueError: known labels contradict each other, or are of other markers or points.
    """
    settings = dataclasses.replace(settings or Settings(), method="full", rescale=False)
    points = known_points(labelling.recording, labelling.model.markers, known)
    control = corrected(labelling.trajectories, _held(labelling), points, labelling.model, settings, tuning)
    return labelling_of(labelling.recording, next((driver or Driver()).run([control])))


def _held(labelling: Labelling) -> Int[np.ndarray, " trajectories"]:
    """The labels given out, and those that were only withheld."""
    if labelling.could_be is None:
        return labelling.identity
    withheld = np.array([reason in WITHHELD for reason in labelling.reason], bool)
    return np.where(withheld, labelling.could_be[:, 0], labelling.identity).astype(np.int32)
