"""Trajectories that are two points one after the other: found by what their own frames say, and cut.

Two points that pass each other closely can be exchanged without a leap, in raw tracking as in the columns of a capture
system. Before or after, the trajectory then fits another label than its own, for as long as it lives.
"""

import numpy as np
from jaxtyping import Float

from dshpm_jax._control.full.objective import Incumbent, Solution
from dshpm_jax._control.full.refine import improve, refine_labels
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import Tuning
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH


def split_trajectories(problem: LabellingProblem, solution: Solution) -> Control[tuple[LabellingProblem, Solution]]:
    """Cuts trajectories where their parts fit different labels; returns the new problem and its solution."""
    for _ in range(problem.tuning.max_split_rounds):
        cuts = propose_cuts(problem, solution)
        if not cuts:
            break
        tracks, source = problem.trajectories.cut(*map(np.array, zip(*cuts)))
        divided, before = problem.of(tracks, source), solution.identity[source]
        after = Incumbent((yield from refine_labels(divided, before)))
        yield from improve(divided, after)
        if (after.solution.identity == before).all():
            break
        problem, solution = divided, after.solution
    return problem, solution


def propose_cuts(problem: LabellingProblem, solution: Solution) -> list[tuple[int, int]]:
    """Trajectories, and the first frame of a later part of each."""
    t, tuning, frames = problem.trajectories, problem.tuning, solution.evidence.frames
    first, last = np.searchsorted(frames, t.start), np.searchsorted(frames, t.stop)
    cuts = set()
    long_enough = last - first >= 2 * tuning.min_part_frames
    for j in np.flatnonzero((solution.identity != NO_MATCH) & long_enough & ~problem.fixed.given).tolist():
        llr = solution.evidence.llr[first[j] : last[j], t.slot[j]].astype(float)
        for row, label in _change_points(llr, int(solution.identity[j]), tuning):
            cuts.add((j, _taken_over(problem, solution, j, label, int(frames[first[j] + row]))))
    return sorted(cuts)


def _change_points(llr: Float[np.ndarray, "frames markers"], own: int, tuning: Tuning) -> list[tuple[int, int]]:
    """Where the part begins and ends that another label fits better than `own` by the most, and that label.

    A cumulative sum of the clipped differences, counted from its lowest point before.
    """
    size, least = len(llr), tuning.min_part_frames
    better = np.clip(llr - llr[:, own, None], -tuning.max_frame_llr, tuning.max_frame_llr)
    total = np.concatenate([np.zeros((1, better.shape[1])), np.cumsum(better, axis=0)])
    since = total - np.minimum.accumulate(total, axis=0)
    end, label = map(int, np.unravel_index(np.argmax(since), since.shape))
    begin = int(np.argmin(total[: end + 1, label]))
    enough = max(tuning.min_part_llr, tuning.min_part_frame_llr * (end - begin))
    if since[end, label] < enough or end - begin < least:
        return []
    return [(row, label) for row in (begin, end) if least <= row <= size - least]


def _taken_over(problem: LabellingProblem, solution: Solution, trajectory: int, label: int, frame: int) -> int:
    """The frame around `frame` from which on the trajectory and one that carries `label` had best be each other's
    continuation; the same for both. `frame` itself where there is no such trajectory."""
    t = problem.trajectories
    reach = round(problem.tuning.max_cut_seconds * t.rate)
    around = np.arange(max(t.start[trajectory] + 1, frame - reach), min(t.stop[trajectory], frame + reach + 1))
    others = np.flatnonzero((solution.identity == label) & (t.start <= around[-1]) & (around[0] < t.stop))
    own, other = (t.positions(np.append(around[0] - 1, around), which) for which in (np.array([trajectory]), others))
    longer = _step(own, other) - _step(own, own)
    longer += np.nan_to_num(_step(other, own) - _step(other, other))  # the other may begin here
    longer = np.where(np.isfinite(longer), longer, np.inf).min(1, initial=np.inf)
    return int(around[np.argmin(longer)]) if np.isfinite(longer).any() else frame


def _step(before: np.ndarray, after: np.ndarray) -> Float[np.ndarray, "frames trajectories"]:
    """How far it is from each frame's points to the next frame's (mm)."""
    return np.linalg.norm(after[1:] - before[:-1], axis=-1)
