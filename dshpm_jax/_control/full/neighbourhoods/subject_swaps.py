"""Moves between several subjects in one recording.

Bodies side by side in like markers fit each other's limbs nearly as well as their own, and a limb that is exchanged as
a whole agrees with itself: no exchange of single labels leads out. So whole segments, limbs and bodies are exchanged.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from jaxtyping import Int
from scipy.sparse.csgraph import connected_components

from dshpm_jax._control.full.moves import Move
from dshpm_jax._control.full.objective import Incumbent
from dshpm_jax._control.full.refine import improve, make_moves
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._hierarchy import subtree
from dshpm_jax._model import Segment
from dshpm_jax._requests import Control
from dshpm_jax._subjects import subjects_of
from dshpm_jax._types import NO_MATCH


def swap_between_subjects(problem: LabellingProblem, incumbent: Incumbent) -> Control[None]:
    """Exchanges parts of subjects for as long as that pays, each time with the moves that follow from it."""
    exchanges = list(_exchanges(problem))
    for _ in range(problem.tuning.max_subject_rounds if exchanges else 0):
        solution = incumbent.solution
        moves = [move for to in exchanges for move in _moves(problem, solution.identity, to)]
        following = yield from make_moves(problem, solution, moves)
        if following is None:
            return
        trial = Incumbent(following)
        yield from improve(problem, trial)
        if not incumbent.offer(problem, trial.solution):
            return


def _exchanges(problem: LabellingProblem) -> Iterator[Int[np.ndarray, " markers"]]:
    """For every two subjects and each part of their bodies, what each marker becomes if that part is exchanged."""
    markers, segments = problem.model.markers, problem.model.segments
    place = {name: k for k, name in enumerate(markers)}
    done = set()
    for one, other in combinations(subjects_of(problem.model), 2):
        for part in _parts(segments):
            to = np.arange(len(markers))
            for k in part:
                subject, _, name = markers[k].rpartition(":")
                twin = place.get(f"{other}:{name}") if subject == one else None
                if twin is not None:
                    to[k], to[twin] = twin, k
            if to.tobytes() not in done and (to != np.arange(len(markers))).any():
                done.add(to.tobytes())
                yield to


def _parts(segments: tuple[Segment, ...]) -> Iterator[set[int]]:
    """The markers of each segment alone, then with all that hangs from it."""
    for s, segment in enumerate(segments):
        yield set(segment.markers)
        yield {marker for below in subtree(segments, s) for marker in segments[below].markers}


def _moves(problem: LabellingProblem, identity: np.ndarray, to: np.ndarray) -> list[Move]:
    """One exchange in each stretch of time that no trajectory of the part bridges."""
    t = problem.trajectories
    touched = np.flatnonzero((identity != NO_MATCH) & (to[identity] != identity))
    start, stop = t.start[touched], t.stop[touched]
    count, stretch = connected_components((start[:, None] < stop[None]) & (start[None] < stop[:, None]), directed=False)
    groups = [touched[stretch == k] for k in range(count)]
    return [Move(group, to[identity[group]], 0.0) for group in groups]
