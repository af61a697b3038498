"""Segments that are missing or fit badly, looked for again now that the rest of the body stands."""

from collections.abc import Container

import numpy as np
from jaxtyping import Bool, Float

from dshpm_jax._control.full.assignment import assign
from dshpm_jax._control.full.evidence import FrameEvidence, of_neighbours, slot_of_marker
from dshpm_jax._control.full.objective import Incumbent, Solution, better_of, gain_in_frames
from dshpm_jax._control.full.refine import refine_best, refine_labels
from dshpm_jax._control.paper.dynamic import accept
from dshpm_jax._control.paper.segment import match_segment
from dshpm_jax._control.partial_labels import PartialLabels
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._geometry import evenly_inside
from dshpm_jax._hierarchy import subtree
from dshpm_jax._requests import Control, Gather
from dshpm_jax._types import NO_MATCH

_Trial = tuple[tuple[int, ...], bool]


def rematch(problem: LabellingProblem, incumbent: Incumbent, only: Container[int] | None = None) -> Control[None]:
    """Looks for missing and badly fitting segments again, alone and with all that hangs from them; keeps what pays.

    Arguments:
        only: the segments that are looked for; all of them by default.
    """
    tuning, loose = problem.tuning, problem.loosened(problem.tuning.rematch_tolerance)
    for _ in range(tuning.max_rematch_rounds):
        solution = incumbent.solution
        lacking = frames_lacking_evidence(problem, solution)
        lacking = {s: frames for s, frames in lacking.items() if only is None or s in only}
        trials = [trial for s in list(lacking)[: tuning.max_rematched] for trial in _trials(problem, s)]
        if not trials:
            return
        votes = yield Gather(tuple(_votes(loose, solution, *trial, lacking[trial[0][0]]) for trial in trials))
        better, worth = yield from _refined(problem, solution, [[one] for one in votes])
        pays = [one for one, found in zip(votes, worth) if found > solution.objective]
        if len(pays) > 1:
            together, _ = yield from _refined(problem, solution, [pays])
            better = better_of(better, together)
        if not incumbent.offer(problem, better):
            return


def _refined(
    problem: LabellingProblem, solution: Solution, votes: list[list[np.ndarray]]
) -> Control[tuple[Solution, list[float]]]:
    """The best that becomes of a solution with a set of votes on top, and what it is worth with each of them."""
    proposals = [_merged(problem, solution, some) for some in votes]
    distinct = {p.tobytes(): p for p in proposals if (p != solution.identity).any()}
    if not distinct:
        return solution, [solution.objective] * len(proposals)
    refinements = [refine_labels(problem, p, solution.evidence) for p in distinct.values()]
    best, worth = yield from refine_best(refinements, solution.evidence)
    after = dict(zip(distinct, worth))
    return best, [after.get(p.tobytes(), solution.objective) for p in proposals]


def frames_lacking_evidence(problem: LabellingProblem, solution: Solution) -> dict[int, list[int]]:
    """Some frames in which a segment is missing or fits badly, for every such segment, the worst first."""
    short, tuning = shortfall(problem, solution), problem.tuning
    order = np.argsort(-short.sum(1), kind="stable")
    lacking = {int(s): solution.evidence.frames[short[s] > 0] for s in order}
    return {
        s: frames[evenly_inside(len(frames), min(len(frames), tuning.rematch_frames))].tolist()
        for s, frames in lacking.items()
        if (short[s] > 0).mean() > tuning.max_poor_share
    }


def shortfall(problem: LabellingProblem, solution: Solution) -> Float[np.ndarray, "segments frames"]:
    """What the labels of a segment lack in each sampled frame (nats), where that is much.

    Frames in which its markers are merely hidden do not count: nothing would be found there.
    """
    gain, usual = gain_in_frames(problem, solution.evidence), problem.prepared.usual_gain
    unsettled = _unsettled(problem, solution.evidence, gain)
    held = np.stack([gain[:, target.markers].sum(1) for target in problem.targets])
    expected = np.array([usual[target.markers].sum() for target in problem.targets])[:, None]
    there = held > 0  # where most of the body is missing, all that is missing would be as good as the average
    average = np.median((held / expected)[there]) if there.any() else 1.0
    short = np.maximum(problem.tuning.min_evidence_share * average * expected - held, 0.0)
    return short * np.stack([unsettled[:, target.markers].any(1) for target in problem.targets])


def _unsettled(
    problem: LabellingProblem, found: FrameEvidence, gain: Float[np.ndarray, "frames markers"]
) -> Bool[np.ndarray, "frames markers"]:
    """Markers that may be elsewhere in a frame than where they are, or that may be there at all.

    Their label does not pay; or they have none, and a point without label might be theirs, or too few of their
    neighbours are known to tell.
    """
    held = slot_of_marker(found.labels, problem.model.num_markers) != NO_MATCH
    known = of_neighbours(problem, held).sum(-1)
    unnamed = np.where((found.labels == NO_MATCH)[..., None], found.llr, -np.inf).max(1)
    tuning = problem.tuning
    return np.where(held, gain < 0, (unnamed > tuning.min_take_llr) | (known < tuning.min_distances))


def _trials(problem: LabellingProblem, segment: int) -> list[_Trial]:
    """The segment alone, with its joins and without, and with all that hangs from it."""
    chain = tuple(subtree(problem.model.segments, segment))
    alone = [((segment,), True), ((segment,), False)]
    return alone if len(chain) == 1 else [*alone, (chain, True), (chain, False)]


def _votes(
    problem: LabellingProblem, solution: Solution, chain: tuple[int, ...], use_joins: bool, frames: list[int]
) -> Control[np.ndarray]:
    """Matches of a chain of segments in several frames, as votes for labels."""
    own = np.unique(np.concatenate([problem.targets[s].markers for s in chain]))
    shared = () if not use_joins else problem.model.segments[chain[0]].join
    identity = solution.identity
    if not use_joins or len(chain) > 1:  # what is there of the segment may be what is wrong
        identity = np.where(np.isin(identity, np.setdiff1d(own, shared)), NO_MATCH, identity)
    parts = yield Gather(tuple(_match_chain(problem, identity, chain, frame, use_joins) for frame in frames))
    votes = np.zeros(
        (len(problem.trajectories), problem.model.num_markers), np.uint8
    )  # there are many trials of few frames
    for part in parts:
        named = np.flatnonzero(np.isin(part, own))
        votes[named, part[named]] += 1
    return votes


def _match_chain(
    problem: LabellingProblem, identity: np.ndarray, chain: tuple[int, ...], frame: int, use_joins: bool
) -> Control[np.ndarray]:
    """Labels after matching the chain's segments in one frame; only what was matched here."""
    known = PartialLabels.of(problem, identity, found=True)
    matched = np.full(len(identity), NO_MATCH)
    for segment in chain:
        match = yield from match_segment(problem, known, segment, frame, use_joins or segment != chain[0])
        if match is not None:
            accept(problem, known, match)
            there = match.trajectories != NO_MATCH
            matched[match.trajectories[there]] = problem.targets[segment].markers[there]
    return matched


def _merged(problem: LabellingProblem, solution: Solution, votes: list[np.ndarray]) -> np.ndarray:
    """The solution's labels with the votes on top, where a vote outweighs what a trajectory had."""
    t = problem.trajectories
    total = np.sum(votes, axis=0)
    held = np.zeros(total.shape)
    named = np.flatnonzero(solution.identity != NO_MATCH)
    held[named, solution.identity[named]] = problem.tuning.held_votes
    return assign(problem, (total + held) * (t.stop - t.start)[:, None])
