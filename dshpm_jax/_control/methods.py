"""The methods, each one control a recording: the paper's dynamic and static schemes, and the full method."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._control.fixed_labels import FixedLabels
from dshpm_jax._control.full.confidence import finalise
from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.full.search import solve
from dshpm_jax._control.paper.dynamic import identify, key_frame
from dshpm_jax._control.paper.propagation import propagate
from dshpm_jax._control.partial_labels import PartialLabels
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._control.unseen.label import label_unseen
from dshpm_jax._control.uses.population import rescaled
from dshpm_jax._labelling import Reason
from dshpm_jax._marker_set import MarkerSet, Member
from dshpm_jax._model import SubjectModel
from dshpm_jax._requests import Control, CountFits, Gather
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True, eq=False)
class Answer:
    """The labels of one recording.

    Attributes:
        model: the model of which they are: that given, or rescaled.
        trajectories: as they were judged; the full method may have split some.
        identity, confidence, reason: of each trajectory, see `Labelling`.
        could_be: what else each could be; None if the method does not know.
        model_fit: the evidence that the labels hold against what right ones do; None if the method does not know.
        fits: rigid fits that it all took (section 5.2.3).
        against: which labels are given although the evidence is against them; none if the method knows no evidence.
    """

    model: SubjectModel
    trajectories: Trajectories
    identity: Int[np.ndarray, " trajectories"]
    confidence: Float[np.ndarray, " trajectories"]
    reason: tuple[Reason, ...]
    could_be: Int[np.ndarray, "trajectories 2"] | None
    model_fit: float | None
    fits: int
    against: Bool[np.ndarray, " trajectories"]


def label_control(
    trajectories: Trajectories,
    model: SubjectModel | MarkerSet | Member,
    settings: Settings,
    tuning: Tuning = TUNING,
    fixed: FixedLabels | None = None,
) -> Control[Answer]:
    """The control for one recording.

    Arguments:
        fixed: the labels that are given, if any are.
    """
    fixed = fixed or FixedLabels.none(trajectories)
    if isinstance(model, MarkerSet | Member):
        return (yield from _unseen(trajectories, model, settings, tuning, fixed))
    if settings.rescale:
        model = yield from rescaled(trajectories, model, settings, tuning)
    problem = LabellingProblem(trajectories, model, settings, tuning, fixed=fixed)
    if settings.method == "full":
        return (yield from _full(problem))
    known = yield from (_static if settings.method == "static" else _dynamic)(problem)
    return (yield from _answer(problem, known))


def _full(problem: LabellingProblem) -> Control[Answer]:
    return (yield from final_answer(*(yield from solve(problem))))


def final_answer(problem: LabellingProblem, solution: Solution) -> Control[Answer]:
    """A solution of the full method as it is given out."""
    final = yield from finalise(problem, solution)
    fits: int = yield CountFits()
    labels = final.identity, final.confidence, final.reason, final.could_be, final.model_fit
    return Answer(problem.model, problem.trajectories, *labels, fits, final.against)


def _unseen(
    trajectories: Trajectories, subject: MarkerSet | Member, settings: Settings, tuning: Tuning, fixed: FixedLabels
) -> Control[Answer]:
    """A subject of whom nothing is labelled."""
    check_for_sets(settings)
    found = yield from label_unseen(trajectories, subject, settings, tuning, fixed)
    final = found.final
    fits: int = yield CountFits()
    labels = final.identity, final.confidence, final.reason, final.could_be, final.model_fit
    return Answer(found.problem.model, found.problem.trajectories, *labels, fits, final.against)


def check_for_sets(settings: Settings) -> None:
    """Raises ValueError where the settings are none for a marker set."""
    if settings.method != "full" or settings.rescale:
        raise ValueError(
            'a marker set labels with the method "full" and finds the size of the subject itself; give no other method '
            "and leave out --rescale"
        )


def _dynamic(problem: LabellingProblem) -> Control[PartialLabels]:
    """The paper's method: one key-frame range, then propagation both ways (sections 4.2 to 4.5)."""
    frame = key_frame(problem)
    known = yield from identify(problem, frame)
    yield from propagate(problem, known, frame)
    return known


def _static(problem: LabellingProblem) -> Control[PartialLabels]:
    """Every frame alone, without tracks (the baseline of section 5.2.1); all frames side by side."""
    frames = range(problem.trajectories.num_frames)
    parts = yield Gather(tuple(_single_frame(problem, frame) for frame in frames))
    known = PartialLabels.nothing(problem)
    for here, part in parts:
        known.identity[here], known.recruited[here] = part.identity, part.recruited
        known.found |= part.found
    return known


def _single_frame(problem: LabellingProblem, frame: int) -> Control[tuple[np.ndarray, PartialLabels]]:
    here, alone = problem.trajectories.single(frame)
    source = here[alone.column[0, alone.slot]]
    known = yield from identify(problem.of(alone, source), 0)
    return source, known


def _answer(problem: LabellingProblem, known: PartialLabels) -> Control[Answer]:
    """The paper accepts or abandons; it has no degrees of confidence."""
    named = known.identity != NO_MATCH
    lost = Reason.OUTSIDE if known.found.all() else Reason.ABANDONED
    given = [Reason.RECRUITED if recruited else Reason.MATCHED for recruited in known.recruited]
    reason = (g if n else lost for g, n in zip(given, named))
    reason = tuple(Reason.KNOWN if fixed else other for fixed, other in zip(known.given, reason))
    fits: int = yield CountFits()
    labels = known.identity, np.where(known.given, 1.0, named), reason
    return Answer(problem.model, problem.trajectories, *labels, None, None, fits, np.zeros(len(named), bool))
