"""A correction solved anew: from the labels that were there, around what it says."""

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.fixed_labels import FixedLabels, fix
from dshpm_jax._control.full.objective import Incumbent
from dshpm_jax._control.full.refine import improve, refine_labels
from dshpm_jax._control.full.rematch import rematch
from dshpm_jax._control.methods import Answer, final_answer
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._model import SubjectModel
from dshpm_jax._requests import Control
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import UNKNOWN


def corrected(
    t: Trajectories,
    before: Int[np.ndarray, " trajectories"],
    known: Int[np.ndarray, "frames columns"],
    model: SubjectModel,
    settings: Settings,
    tuning: Tuning = TUNING,
) -> Control[Answer]:
    """Labels around those that are known, from others that were there; no key-frame is asked.

    Arguments:
        before: the labels that the trajectories had.
        known: what is known of each point, see `known_points`.
    """
    t, identity, whole = fix(t, known)
    t, start, identity = _freed(t, before[whole], identity)
    fixed = FixedLabels.of(t, identity, model.num_markers)
    problem = LabellingProblem(t, model, settings, tuning, fixed=fixed)
    incumbent = Incumbent((yield from refine_labels(problem, start)))
    yield from improve(problem, incumbent)
    yield from rematch(problem, incumbent)
    return (yield from final_answer(problem, incumbent.solution))


def _freed(t: Trajectories, start: np.ndarray, known: np.ndarray) -> tuple[Trajectories, np.ndarray, np.ndarray]:
    """Whoever had a label that is known to be another's for a while keeps it before and after: cut there.

    Returns the trajectories, the labels that they had and what is known of them.
    """
    cuts = set()
    for j in np.flatnonzero(known >= 0):
        meet = (known == UNKNOWN) & (start == known[j]) & (t.start < t.stop[j]) & (t.start[j] < t.stop)
        for k in np.flatnonzero(meet).tolist():
            cuts |= {(k, end) for end in (int(t.start[j]), int(t.stop[j])) if t.start[k] < end < t.stop[k]}
    if not cuts:
        return t, start, known
    t, source = t.cut(*map(np.array, zip(*sorted(cuts))))
    return t, start[source], known[source]
