"""A correction solved anew: from the labels that were there, around what it says."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Int

from dshpm_jax._control.fixed_labels import FixedLabels, fix
from dshpm_jax._control.full.confidence import finalise
from dshpm_jax._control.full.objective import Incumbent, Solution
from dshpm_jax._control.full.refine import improve, refine_labels
from dshpm_jax._control.full.rematch import rematch
from dshpm_jax._control.methods import Answer
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._labelling import WITHHELD, Labelling, Reason
from dshpm_jax._requests import Control, CountFits
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import NO_MATCH, NO_PARENT, UNKNOWN


def corrected(
    labelling: Labelling,
    known: Int[np.ndarray, "frames columns"],
    new: Bool[np.ndarray, "frames columns"],
    settings: Settings,
    tuning: Tuning = TUNING,
) -> Control[Answer]:
    """Labels around those that are known, from others that were there; no key-frame is asked.

    Only trajectories that share a frame with one of which something new is known are judged anew, and only the frames
    that show these are looked at.

    Arguments:
        known: what is known of each point, see `known_points`.
        new: where it is new.
    """
    model = labelling.model
    t, given, whole = fix(labelling.trajectories, known)
    t, source = _freed(t, _held(labelling)[whole], given)
    whole, given = whole[source], given[source]
    answer = _as_it_was(labelling, t, whole, given)
    before = _held(labelling)[whole]
    was_given = np.array([reason == Reason.KNOWN for reason in labelling.reason])[whole]
    changed = new[t.start, t.column[t.start, t.slot]] & (given != UNKNOWN)
    changed |= (FixedLabels.of(t, given, model.num_markers).on(before) != before) | (was_given & (given == UNKNOWN))
    if not changed.any():
        return answer
    near = _beside(t, changed)
    part, which = t.between(int(t.start[near].min()), int(t.stop[near].max()))
    stays = np.where((given[which] == UNKNOWN) & ~near[which], before[which], given[which])
    fixed = FixedLabels.of(part, stays, model.num_markers)
    problem = LabellingProblem(part, model, settings, tuning, fixed=fixed)
    solution = yield from _solved(problem, before[which])
    return (yield from _written(answer, problem, solution, which, near))


def _solved(problem: LabellingProblem, before: Int[np.ndarray, " trajectories"]) -> Control[Solution]:
    """The best labels that those before lead to."""
    incumbent = Incumbent((yield from refine_labels(problem, before)))
    yield from improve(problem, incumbent)
    yield from rematch(problem, incumbent, _touched(problem, before, incumbent.solution.identity))
    return incumbent.solution


def _held(labelling: Labelling) -> Int[np.ndarray, " trajectories"]:
    """The labels given out, and those that were only withheld."""
    if labelling.could_be is None:
        return labelling.identity
    withheld = np.array([reason in WITHHELD for reason in labelling.reason], bool)
    return np.where(withheld, labelling.could_be[:, 0], labelling.identity).astype(np.int32)


def _freed(t: Trajectories, before: np.ndarray, given: np.ndarray) -> tuple[Trajectories, np.ndarray]:
    """Whoever had a label that is known to be another's for a while can keep it before and after: cut there.

    Returns the trajectories, and which each was part of.
    """
    cuts = set()
    for j in np.flatnonzero(given >= 0):
        meet = (given == UNKNOWN) & (before == given[j]) & (t.start < t.stop[j]) & (t.start[j] < t.stop)
        for k in np.flatnonzero(meet).tolist():
            cuts |= {(k, end) for end in (int(t.start[j]), int(t.stop[j])) if t.start[k] < end < t.stop[k]}
    return t.cut(*map(np.array, zip(*sorted(cuts)))) if cuts else (t, np.arange(len(t)))


def _as_it_was(labelling: Labelling, t: Trajectories, whole: np.ndarray, given: np.ndarray) -> Answer:
    """What was decided about trajectories that are parts of others, and what is known of them now."""
    said = given != UNKNOWN
    reason = tuple(Reason.KNOWN if now else labelling.reason[j] for now, j in zip(said, whole))
    others = np.full((len(t), 2), NO_MATCH, np.int32) if labelling.could_be is None else labelling.could_be[whole]
    return Answer(
        labelling.model,
        t,
        np.where(said, given, labelling.identity[whole]).astype(np.int32),
        np.where(said, 1.0, labelling.confidence[whole]),
        reason,
        np.where(said[:, None], NO_MATCH, others).astype(np.int32),
        labelling.stats.get("model_fit"),
        0,
        np.zeros(len(t), bool),
    )


def _beside(t: Trajectories, changed: Bool[np.ndarray, " trajectories"]) -> Bool[np.ndarray, " trajectories"]:
    """The trajectories that share a frame with one of those that changed."""
    busy = np.zeros(t.num_frames + 1, int)
    np.add.at(busy, t.start[changed], 1)
    np.add.at(busy, t.stop[changed], -1)
    seen = np.concatenate([[0], np.cumsum(np.cumsum(busy)[:-1] > 0)])
    return seen[t.stop] > seen[t.start]


def _touched(problem: LabellingProblem, before: np.ndarray, now: np.ndarray) -> set[int]:
    """The segments of which a label has changed hands, and those that are joined to them."""
    changed = np.setdiff1d(np.concatenate([before[before != now], now[before != now]]), [NO_MATCH])
    segments = problem.model.segments
    own = {s for s, segment in enumerate(segments) if np.isin(segment.markers, changed).any()}
    joined = {segments[s].parent for s in own} | {s for s, segment in enumerate(segments) if segment.parent in own}
    return own | joined - {NO_PARENT}


def _written(
    answer: Answer, problem: LabellingProblem, solution: Solution, which: np.ndarray, near: np.ndarray
) -> Control[Answer]:
    """The answer with what was found about some of its trajectories.

    Arguments:
        which: the trajectories of the problem in the answer.
        near: the trajectories of the answer that were judged anew.
    """
    final = yield from finalise(problem, solution, answer.model_fit)
    judged = near[which]
    there = which[judged]
    fields = {name: getattr(answer, name).copy() for name in ("identity", "confidence", "could_be", "against")}
    for name, values in fields.items():
        values[there] = getattr(final, name)[judged]
    new = dict(zip(there.tolist(), np.flatnonzero(judged).tolist()))
    reason = tuple(final.reason[new[j]] if j in new else old for j, old in enumerate(answer.reason))
    fits: int = yield CountFits()
    return replace(answer, **fields, reason=reason, fits=fits)
