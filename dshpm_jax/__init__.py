"""Labels unlabelled optical motion capture against an articulated marker model, without training."""

import logging
from importlib import import_module
from typing import TYPE_CHECKING, Any

from dshpm_jax._given import combine_models as combine_models
from dshpm_jax._known import KnownLabel as KnownLabel
from dshpm_jax._labelling import Labelling as Labelling
from dshpm_jax._labelling import Reason as Reason
from dshpm_jax._marker_set import MarkerSet as MarkerSet
from dshpm_jax._marker_set import Member as Member
from dshpm_jax._model import Segment as Segment
from dshpm_jax._model import SubjectModel as SubjectModel
from dshpm_jax._recording import Recording as Recording
from dshpm_jax._settings import Settings as Settings
from dshpm_jax.io import read as read
from dshpm_jax.io import read_marker_set as read_marker_set
from dshpm_jax.io import read_model as read_model
from dshpm_jax.io import write_c3d as write_c3d
from dshpm_jax.io import write_filled as write_filled
from dshpm_jax.io import write_labelled as write_labelled
from dshpm_jax.io import write_marker_set as write_marker_set
from dshpm_jax.io import write_model as write_model
from dshpm_jax.io import write_sidecar as write_sidecar
from dshpm_jax.report import view as view
from dshpm_jax.report import view_frame as view_frame

# What is logged goes where a program that uses the library sends it, and nowhere else.
logging.getLogger(__name__).addHandler(logging.NullHandler())

if TYPE_CHECKING:
    from dshpm_jax import evaluation as evaluation
    from dshpm_jax import io as io
    from dshpm_jax import report as report
    from dshpm_jax import synthesis as synthesis
    from dshpm_jax._check import Finding as Finding
    from dshpm_jax._check import check as check
    from dshpm_jax._correct import correct as correct
    from dshpm_jax._driver import Driver as Driver
    from dshpm_jax._label import label as label
    from dshpm_jax._label import label_many as label_many
    from dshpm_jax._live import LabelledFrames as LabelledFrames
    from dshpm_jax._live import Labeller as Labeller
    from dshpm_jax._reconstruction import Filled as Filled
    from dshpm_jax._reconstruction import Found as Found
    from dshpm_jax._reconstruction import Motion as Motion
    from dshpm_jax._reconstruction import reconstruct as reconstruct
    from dshpm_jax._reconstruction import write_motion as write_motion
    from dshpm_jax._review.notebook import Review as Review
    from dshpm_jax._review.notebook import review as review
    from dshpm_jax._scoring import AbstractCandidateScore as AbstractCandidateScore
    from dshpm_jax._scoring import AbstractMatchScore as AbstractMatchScore
    from dshpm_jax._scoring import GaussianCandidate as GaussianCandidate
    from dshpm_jax._scoring import GaussianMatch as GaussianMatch
    from dshpm_jax._scoring import MaxResidual as MaxResidual
    from dshpm_jax._scoring import MeanResidual as MeanResidual
    from dshpm_jax._scoring import RmsResidual as RmsResidual
    from dshpm_jax._scoring import RobustResidual as RobustResidual
    from dshpm_jax._scoring import ToleranceScore as ToleranceScore
    from dshpm_jax._unseen import find_subject as find_subject

    __version__: str

__all__ = [
    "__version__",
    "AbstractCandidateScore",
    "AbstractMatchScore",
    "check",
    "combine_models",
    "correct",
    "Driver",
    "evaluation",
    "Filled",
    "find_subject",
    "Finding",
    "Found",
    "GaussianCandidate",
    "GaussianMatch",
    "io",
    "KnownLabel",
    "label",
    "label_many",
    "LabelledFrames",
    "Labeller",
    "Labelling",
    "MarkerSet",
    "MaxResidual",
    "MeanResidual",
    "Member",
    "Motion",
    "read",
    "read_marker_set",
    "read_model",
    "Reason",
    "reconstruct",
    "Recording",
    "report",
    "review",
    "Review",
    "RmsResidual",
    "RobustResidual",
    "Segment",
    "Settings",
    "SubjectModel",
    "synthesis",
    "ToleranceScore",
    "view",
    "view_frame",
    "write_c3d",
    "write_filled",
    "write_labelled",
    "write_marker_set",
    "write_model",
    "write_motion",
    "write_sidecar",
]

# Importing jax or scipy takes a second, which reading files, models and `--help` need not wait for.
_ON_DEMAND = {
    "Finding": "_check",
    "check": "_check",
    "correct": "_correct",
    "Driver": "_driver",
    "label": "_label",
    "label_many": "_label",
    "LabelledFrames": "_live",
    "Labeller": "_live",
    "Filled": "_reconstruction",
    "Found": "_reconstruction",
    "Motion": "_reconstruction",
    "reconstruct": "_reconstruction",
    "write_motion": "_reconstruction",
    "Review": "_review.notebook",
    "review": "_review.notebook",
    "AbstractCandidateScore": "_scoring",
    "AbstractMatchScore": "_scoring",
    "GaussianCandidate": "_scoring",
    "GaussianMatch": "_scoring",
    "MaxResidual": "_scoring",
    "MeanResidual": "_scoring",
    "RmsResidual": "_scoring",
    "RobustResidual": "_scoring",
    "ToleranceScore": "_scoring",
    "find_subject": "_unseen",
}
_ROOMS = ("evaluation", "io", "report", "synthesis")


def __getattr__(name: str) -> Any:
    """Names that need jax or scipy, imported when they are first asked for, and the version that is installed."""
    if name in _ON_DEMAND:
        return getattr(import_module(f"{__name__}.{_ON_DEMAND[name]}"), name)
    if name in _ROOMS:
        return import_module(f"{__name__}.{name}")
    if name == "__version__":
        from importlib.metadata import version

        return version("dshpm-jax")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """The public names, and nothing of how they come here."""
    return list(__all__)
