"""`correct`: what follows from a person's labels, at once."""

import dataclasses
from collections.abc import Sequence

from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._control.uses.correcting import corrected
from dshpm_jax._driver import Driver
from dshpm_jax._known import KnownLabel, points_of
from dshpm_jax._label import labelling_of, points_given
from dshpm_jax._labelling import Labelling
from dshpm_jax._settings import Settings


def correct(
    labelling: Labelling,
    known: Sequence[KnownLabel],
    settings: Settings | None = None,
    driver: Driver | None = None,
    tuning: Tuning = TUNING,
    new: Sequence[KnownLabel] | None = None,
) -> Labelling:
    """Labels a recording anew around labels that are known, starting from those that it has.

    This is much faster than `label(recording, model, known=...)`, as nothing is searched for: what the known labels
    leave room for stays unless the evidence is against it now. What it gives depends on the labels before; a result is
    made with `label`.

    Arguments:
        labelling: of the full method, or one that was corrected before.
        known: all labels that are known, also those that were known before.
        settings, driver, tuning: as for `label`; the method is the full one.
        new: those of `known` that were said since; only what is seen together with these, or with a label that changes,
            is judged anew. All of them by default.

    Raises:
        ValueError: known labels contradict each other, or are of other markers or points.
    """
    settings = dataclasses.replace(settings or Settings(), method="full", rescale=False)
    known_now = points_given(labelling.recording, labelling.model, known, settings)
    said = points_of(labelling.recording, known if new is None else new)
    control = corrected(labelling, known_now, said, settings, tuning)
    return labelling_of(labelling.recording, next((driver or Driver()).run([control])))
