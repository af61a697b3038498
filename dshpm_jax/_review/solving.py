"""What else a correction changes: solved anew around it."""

from collections.abc import Sequence

from dshpm_jax._known import KnownLabel
from dshpm_jax._labelling import Labelling
from dshpm_jax._review.session import Solver
from dshpm_jax._settings import Settings


def solver_for(settings: Settings) -> Solver | None:
    """A solver with the settings that a result was made with; None where its method solves nothing anew."""
    if settings.method != "full" or settings.rescale:
        return None

    def solve(labelling: Labelling, known: Sequence[KnownLabel]) -> Labelling:
        from dshpm_jax._correct import correct  # jax is slow to start, and not needed to look at labels

        return correct(labelling, known, settings)

    return solve
