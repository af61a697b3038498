"""Whole chains of labels exchanged with their counterparts, where they carry each other's: for good or for a while.

In the same breath, labels of near markers are permuted for good (`permutations`).
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.full.moves import Move
from dshpm_jax._control.full.neighbourhoods.permutations import propose_permutations
from dshpm_jax._control.full.objective import Incumbent, Solution
from dshpm_jax._control.full.refine import make_moves
from dshpm_jax._control.full.rematch import shortfall
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH


def swap_sides(problem: LabellingProblem, incumbent: Incumbent) -> Control[None]:
    """Exchanges chains, and permutes near labels, for as long as that pays."""
    for _ in range(problem.tuning.max_side_rounds):
        moves = [*_for_good(problem, incumbent.solution), *_for_a_while(problem, incumbent.solution)]
        moves += propose_permutations(problem, incumbent.solution)
        following = yield from make_moves(problem, incumbent.solution, moves)
        if not incumbent.offer(problem, following):
            return


def _for_good(problem: LabellingProblem, solution: Solution) -> Iterator[Move]:
    """Each exchange of chains, over the whole recording."""
    for to in problem.prepared.side_permutations:
        changed = _exchanged(solution, to)
        if len(changed):
            yield Move(changed, to[solution.identity[changed]], 0.0)


def _for_a_while(problem: LabellingProblem, solution: Solution) -> list[Move]:
    """Exchanges in spells in which the labels of the chains lack more than they usually do."""
    moves: dict[bytes, Move] = {}
    t, tuning, targets, usual = problem.trajectories, problem.tuning, problem.targets, problem.prepared.usual_gain
    frames, short = solution.evidence.frames, shortfall(problem, solution)
    shortest = max(1, round(tuning.min_spell_seconds * t.rate / np.diff(frames).max(initial=1)))
    for to in problem.prepared.side_permutations:
        changed = _exchanged(solution, to)
        chains = [k for k, target in enumerate(targets) if (to[target.markers] != target.markers).any()]
        expected = sum(usual[targets[k].markers].sum() for k in chains)
        for first, last, excess in _spells(short[chains].sum(0), shortest, tuning.min_spell_shortfall * expected):
            begin, end = frames[first], frames[last]
            inside = np.minimum(t.stop[changed], end + 1) - np.maximum(t.start[changed], begin)
            within = changed[2 * inside > (t.stop - t.start)[changed]]
            if 0 < len(within) < len(changed):
                move = Move(within, to[solution.identity[within]], excess)
                moves.setdefault(move.trajectories.tobytes() + move.labels.tobytes(), move)
    return sorted(moves.values(), key=lambda move: -move.promise)[: tuning.max_spells]


def _spells(lack: Float[np.ndarray, " frames"], shortest: int, least: float) -> Iterator[tuple[int, int, float]]:
    """Halves, quarters and so on of the recording, and those between them, that lack `least` in a frame.

    Yields the first and the last frame, and what the spell lacks more than the recording on average.
    """
    total = np.concatenate([[0.0], np.cumsum(lack)])
    length = len(lack) // 2
    while length >= shortest:
        for first in range(0, len(lack) - length + 1, max(1, length // 2)):
            lacks = float(total[first + length] - total[first])
            if lacks >= least * length and lacks > length * lack.mean():
                yield first, first + length - 1, lacks - length * lack.mean()
        length //= 2


def _exchanged(solution: Solution, to: Int[np.ndarray, " markers"]) -> Int[np.ndarray, " changed"]:
    """The trajectories whose label an exchange changes."""
    return np.flatnonzero((solution.identity != NO_MATCH) & (to[solution.identity] != solution.identity))
