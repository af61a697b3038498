"""From first labels to ones that hold: judged over whole lives and assigned in turn, then bettered by moves."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.full.assignment import any_overlap, assign, margins
from dshpm_jax._control.full.evidence import FrameEvidence, evidence_after, evidence_in, labels_in, sample_frames
from dshpm_jax._control.full.moves import Move, apply_moves, around_fixed, judge_moves
from dshpm_jax._control.full.neighbourhoods.exchanges import propose_moves
from dshpm_jax._control.full.objective import Incumbent, Solution, better_of, gains
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._requests import Control, Gather
from dshpm_jax._types import NO_MATCH

EVIDENCE_BYTES, EVIDENCE_COPIES = 256 << 20, 3
"""How much evidence may be kept at a time by what is refined side by side, and how often each keeps it."""


def refine_labels(
    problem: LabellingProblem,
    identity: Int[np.ndarray, " trajectories"],
    evidence: FrameEvidence | None = None,
    schedule: Sequence[float] = (0.0,),
) -> Control[Solution]:
    """Judges and assigns in turn until nothing changes; returns the best solution on the way.

    `identity` may give one label to trajectories that share a frame; what that would be worth is no measure. Labels
    that are given take their places in it, whoever proposed it.

    Arguments:
        evidence: of other labels in the frames in which these are judged; by default they are judged afresh.
        schedule: margins (nats) by which a label must win, one after the other.
    """
    tuning, best = problem.tuning, None
    identity = problem.fixed.on(identity)
    overlapping = any_overlap(identity, problem.trajectories.start, problem.trajectories.stop)
    for margin in schedule:
        since = 0
        for _ in range(tuning.max_refine_rounds):
            evidence = yield from _judged(problem, identity, evidence)
            solution = Solution.of(problem, identity, evidence)
            if overlapping:  # but what follows is assigned without any
                solution, overlapping = replace(solution, objective=-np.inf), False
            if best is None or solution.objective > best.objective:
                best, since = solution, 0
            else:
                since += 1
            following = _assigned(problem, solution, margin)
            if (following == identity).all() or (margin == 0 and since >= tuning.patience):
                break
            identity = following
    assert best is not None
    return best


def _judged(problem: LabellingProblem, identity: np.ndarray, before: FrameEvidence | None) -> Control[FrameEvidence]:
    if before is None:
        return (yield from evidence_in(problem, identity, sample_frames(problem)))
    return (yield from evidence_after(problem, before, labels_in(problem, identity, before.frames)))


def refine_best(
    controls: Sequence[Control[Solution]], evidence: FrameEvidence
) -> Control[tuple[Solution, list[float]]]:
    """Runs some `refine_labels`; returns the best solution of all, the first of equals, and what each is worth.

    As many side by side as memory allows: the evidence of a long recording is large, and each keeps several.

    Arguments:
        evidence: of the size that each of them keeps.
    """
    at_once = max(1, EVIDENCE_BYTES // (EVIDENCE_COPIES * max(evidence.llr.nbytes, 1)))
    best, worth = None, []
    for first in range(0, len(controls), at_once):
        solutions: list[Solution] = yield Gather(tuple(controls[first : first + at_once]))
        worth += [solution.objective for solution in solutions]
        for solution in solutions:
            best = solution if best is None else better_of(best, solution)
        del solutions
    assert best is not None
    return best, worth


def _assigned(problem: LabellingProblem, solution: Solution, margin: float) -> Int[np.ndarray, " trajectories"]:
    """The best assignment, less what a rival comes within `margin` nats of: another label, or another trajectory
    for the label while this one lives."""
    t = problem.trajectories
    llr = solution.llr.copy()
    named = np.flatnonzero(solution.identity != NO_MATCH)
    llr[named, solution.identity[named]] += problem.tuning.keep_llr
    identity = assign(problem, gains(problem, llr))
    if margin > 0:
        named = np.flatnonzero(identity != NO_MATCH)
        identity[named[margins(identity, solution.llr, t.start, t.stop)[named] < margin]] = NO_MATCH
    return problem.fixed.on(identity)


def improve(problem: LabellingProblem, incumbent: Incumbent) -> Control[None]:
    """Makes moves for as long as they pay."""
    for _ in range(problem.tuning.max_move_rounds):
        moves = propose_moves(problem, incumbent.solution)
        following = yield from make_moves(problem, incumbent.solution, moves)
        if not incumbent.offer(problem, following):
            return


def make_moves(problem: LabellingProblem, solution: Solution, moves: Sequence[Move]) -> Control[Solution | None]:
    """What becomes of the solution with those of `moves` made that pay, better or worse; None if none does."""
    moves = [move for move in (around_fixed(problem, move) for move in moves) if len(move.trajectories)]
    if not moves:
        return None
    worth = yield from judge_moves(problem, solution, moves)
    changed = apply_moves(solution.identity, moves, worth)
    if (changed == solution.identity).all():
        return None
    return (yield from refine_labels(problem, changed, solution.evidence))
