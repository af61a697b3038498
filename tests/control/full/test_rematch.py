"""Segments that lack evidence are looked for again, and no others."""

from dataclasses import replace

import numpy as np
from takes import model

from dshpm_jax import Settings
from dshpm_jax._control.full.evidence import evidence_in, sample_frames
from dshpm_jax._control.full.objective import Incumbent, Solution
from dshpm_jax._control.full.refine import refine_labels
from dshpm_jax._control.full.rematch import frames_lacking_evidence, rematch
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._types import NO_MATCH


def test_a_segment_without_labels_is_labelled_again(problem, truth, run):
    segment = next(s for s, target in enumerate(problem.targets) if len(target.markers) >= 4)
    own = np.isin(truth, problem.targets[segment].markers)
    bare, frames = np.where(own, NO_MATCH, truth), sample_frames(problem)
    known = run(refine_labels(problem, truth))
    left = Solution(bare, known.llr, -np.inf, run(evidence_in(problem, bare, frames)))
    lacking = frames_lacking_evidence(problem, left)
    assert segment in lacking and set(lacking[segment]) <= set(frames.tolist())
    incumbent = Incumbent(left)
    run(rematch(problem, incumbent))
    assert (incumbent.solution.identity[own] == truth[own]).mean() > 0.9


def test_what_is_missing_lacks_evidence_even_where_most_of_the_body_does(problem, truth, run):
    sizes = [len(target.markers) for target in problem.targets]
    kept = problem.targets[int(np.argmax(sizes))].markers
    bare = np.where(np.isin(truth, kept), truth, NO_MATCH)
    solution = Solution.of(problem, bare, run(evidence_in(problem, bare, sample_frames(problem))))
    assert len(frames_lacking_evidence(problem, solution)) > len(sizes) / 2


def test_a_segment_whose_markers_are_merely_hidden_is_not_looked_for(problem, truth, run):
    segment = next(s for s, target in enumerate(problem.targets) if len(target.markers) >= 4)
    hidden = np.isin(truth, problem.targets[segment].markers[2:]) | (truth == NO_MATCH)  # and no false point is there
    tracks = problem.trajectories
    gone = np.isin(tracks.index, np.flatnonzero(hidden))
    points, index = np.where(gone[..., None], np.nan, tracks.points), np.where(gone, NO_MATCH, tracks.index)
    bare = LabellingProblem(replace(tracks, points=points, index=index), model(), Settings())
    known, frames = np.where(hidden, NO_MATCH, truth), sample_frames(problem)
    solution = run(refine_labels(bare, known, run(evidence_in(bare, known, frames))))
    assert segment not in frames_lacking_evidence(bare, solution)
