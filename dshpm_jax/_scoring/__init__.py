"""Scores that researchers can replace: how well a candidate fits its column, and how well a match fits its segment."""

from dshpm_jax._scoring.candidate import AbstractCandidateScore as AbstractCandidateScore
from dshpm_jax._scoring.candidate import GaussianCandidate as GaussianCandidate
from dshpm_jax._scoring.candidate import ToleranceScore as ToleranceScore
from dshpm_jax._scoring.check import check_candidate_score as check_candidate_score
from dshpm_jax._scoring.check import check_match_score as check_match_score
from dshpm_jax._scoring.match import AbstractMatchScore as AbstractMatchScore
from dshpm_jax._scoring.match import GaussianMatch as GaussianMatch
from dshpm_jax._scoring.match import MaxResidual as MaxResidual
from dshpm_jax._scoring.match import MeanResidual as MeanResidual
from dshpm_jax._scoring.match import RmsResidual as RmsResidual
from dshpm_jax._scoring.match import RobustResidual as RobustResidual
