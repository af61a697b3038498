"""The full method: evidence from many key-frames, one assignment for the recording, restarts judged without truth."""

from dataclasses import replace

import numpy as np
from jaxtyping import Int

from dshpm_jax._control.full.evidence import fewer_frames
from dshpm_jax._control.full.key_frames import Votes
from dshpm_jax._control.full.neighbourhoods.near_swaps import swap_near
from dshpm_jax._control.full.neighbourhoods.side_swaps import swap_sides
from dshpm_jax._control.full.neighbourhoods.subject_swaps import swap_between_subjects
from dshpm_jax._control.full.objective import Incumbent, Solution, better_of, share_held
from dshpm_jax._control.full.refine import improve, refine_best, refine_labels
from dshpm_jax._control.full.rematch import rematch
from dshpm_jax._control.full.split import split_trajectories
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH

STAGES = (improve, swap_sides, rematch, improve, swap_near, swap_between_subjects)
"""What is done to the best start, each a control that offers the incumbent what is worth more."""


def solve(problem: LabellingProblem, other: Solution | None = None) -> Control[tuple[LabellingProblem, Solution]]:
    """The best labels of a recording: searched for, then trajectories split where their parts fit different labels.

    Arguments:
        other: a solution that is taken if it is worth more than what is found.

    Returns:
        the problem with trajectories as they are split, and its solution.
    """
    found = yield from search(problem)
    best = found if other is None else better_of(other, found)
    problem, solution = yield from split_trajectories(problem, best)
    return problem, replace(solution, divided=best.divided)


def improved_from(problem: LabellingProblem, identity: Int[np.ndarray, " trajectories"]) -> Control[Solution]:
    """What all stages make of these labels, which stand instead of those of key-frames."""
    incumbent = Incumbent((yield from refine_labels(problem, identity)))
    yield from _through_stages(problem, incumbent)
    return incumbent.solution


def search(problem: LabellingProblem) -> Control[Solution]:
    """The best solution that key-frames, restarts and all stages lead to."""
    votes = Votes.none(problem)
    best = yield from _led_by(problem, votes, 1.0)
    if votes.divided:
        return (yield from _best_of_several(problem, best))
    return best


def _best_of_several(problem: LabellingProblem, first: Solution) -> Control[Solution]:
    """The best of several starts and the first, without the labels that the others do not lead to.

    Where the model says little, as that of a static does, what one start leads to is a matter of luck.
    """
    incumbent, found = Incumbent(first), [first.identity]
    del first  # and its evidence, once it is beaten
    for scale in problem.tuning.extra_starts:
        votes = Votes.none(problem)
        solution = yield from _led_by(problem, votes, scale)
        found.append(solution.identity)
        incumbent.offer(problem, solution)
        del solution
        if not votes.divided:
            break
    best = incumbent.solution
    agreed = (np.stack(found) == best.identity).mean(0) >= problem.tuning.min_consensus
    return replace(best, identity=problem.fixed.on(np.where(agreed, best.identity, NO_MATCH)), divided=True)


def _led_by(problem: LabellingProblem, votes: Votes, scale: float) -> Control[Solution]:
    """What `scale` times the usual number of key-frames and all stages lead to.

    The stages are gone through again where what comes after `swap_sides` led farther, as a leg found may show that the
    other is where it should be; and for as long as anything does where labels hold little, as they grow from few where
    much is missing.
    """
    incumbent = Incumbent((yield from _started(problem, votes, scale)))
    for _ in range(problem.tuning.max_passes):
        before = incumbent.objective
        after_swaps = yield from _through_stages(problem, incumbent)
        enough = share_held(problem, incumbent.solution) >= problem.tuning.restart_below
        if incumbent.objective == (after_swaps if enough else before):
            break
    return incumbent.solution


def _through_stages(problem: LabellingProblem, incumbent: Incumbent) -> Control[float]:
    """Goes through all stages; returns what the incumbent was worth after `swap_sides`."""
    improved, after_swaps = None, -np.inf
    for stage in STAGES:
        if stage is improve and incumbent.objective == improved:
            continue  # nothing has changed since the moves were tried
        yield from stage(problem, incumbent)
        improved = incumbent.objective if stage is improve else improved
        after_swaps = incumbent.objective if stage is swap_sides else after_swaps
    return after_swaps


def _started(problem: LabellingProblem, votes: Votes, scale: float) -> Control[Solution]:
    """The best solution that key-frames lead to: few of them where these do, else more, and restarts."""
    tuning = problem.tuning
    solution = yield from _asked(problem, votes, scale * tuning.first_share)
    for k, factor in enumerate(tuning.key_frame_factors):
        share = share_held(problem, solution)
        if votes.agree and share >= tuning.restart_below:
            return solution
        if share >= tuning.more_key_frames_below or (k > 0 and votes.suffice):
            break
        solution = yield from _asked(problem, votes, scale * factor)
    if share_held(problem, solution) >= tuning.more_key_frames_below:
        return (yield from _restarted_in_some(problem, votes.identity, solution))
    return (yield from _restarted(problem, votes.identity, solution))


def _asked(problem: LabellingProblem, votes: Votes, factor: float) -> Control[Solution]:
    """What the votes lead to with this many times the usual number of key-frames."""
    yield from votes.ask(factor)
    return (yield from refine_labels(problem, votes.identity))


def _restarted_in_some(
    problem: LabellingProblem, identity: Int[np.ndarray, " trajectories"], solution: Solution
) -> Control[Solution]:
    """`_restarted`, but judged in some of the frames as long as these show nothing better."""
    frames = solution.evidence.frames
    few = fewer_frames(problem, frames, problem.tuning.restart_frame_step)
    there = Solution.of(problem, solution.identity, solution.evidence.rows(np.searchsorted(frames, few)))
    again = yield from _restarted(problem, identity, there)
    if again is there:
        return solution
    again = yield from refine_labels(problem, again.identity, solution.evidence)
    return better_of(solution, again)


def _restarted(
    problem: LabellingProblem, identity: Int[np.ndarray, " trajectories"], solution: Solution
) -> Control[Solution]:
    """The best that the most certain labels first lead to from `identity`; `solution` itself if none is better."""
    schedules = problem.tuning.restart_schedules
    restarts = [refine_labels(problem, identity, solution.evidence, schedule) for schedule in schedules]
    again, _ = yield from refine_best(restarts, solution.evidence)
    return better_of(solution, again)
