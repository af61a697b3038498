"""What is in doubt, and why."""

import pytest
from making import make_labelling, make_recording

from dshpm_jax import Reason, io
from dshpm_jax._control.tuning import TUNING
from dshpm_jax.report._doubts import ANOTHERS, BADLY, BRIEFLY, LOOSELY, TIED, doubt_of, troubles_of

RATE = 100.0


def track(confidence: float, label: str | None = "A", frames: int = 200, reason: Reason = Reason.MATCHED, **more):
    return {"label": label, "frames": [10, 9 + frames], "confidence": confidence, "reason": str(reason), **more}


def sidecar(fit: float = 1.0, **more) -> dict:
    return {"rate": RATE, "stats": {"model_fit": fit}, "trajectories": [track(0.9)], **more}


@pytest.mark.parametrize(
    "sure", [track(0.95), track(0.1, None, reason=Reason.OUTSIDE), track(0.1, None, reason=Reason.TAKEN)]
)
def test_what_is_sure_is_in_no_doubt(sure):
    assert doubt_of(sure, sidecar()) is None


@pytest.mark.parametrize(
    "unsure, about, cause",
    [
        (track(0.94), sidecar(), LOOSELY),
        (track(0.8, frames=200), sidecar(), LOOSELY),
        (track(0.9, frames=2), sidecar(), BRIEFLY),
        (track(0.1, frames=20), sidecar(), LOOSELY),
        (track(TUNING.poor_fit_share), sidecar(0.6), BADLY),
        (track(0.75), sidecar(0.6), LOOSELY),
        (track(0.85), sidecar(settings={"rescale": True}), ANOTHERS),
        (track(0.7), sidecar(settings={"rescale": True}), LOOSELY),
        (track(0.45, None, reason=Reason.DOUBTFUL), sidecar(), LOOSELY),
        (track(0.45, None, reason=Reason.AMBIGUOUS), sidecar(), TIED),
    ],
)
def test_the_cause(unsure, about, cause):
    doubt = doubt_of(unsure, about)
    assert doubt is not None and doubt.cause == cause and doubt.points == unsure["frames"][1] - 9


def test_its_words():
    withheld = doubt_of(track(0.45, None, reason=Reason.AMBIGUOUS, could_be=["A", "B"]), sidecar())
    assert withheld is not None and withheld.words == f"no label, may be A or B: {TIED}" and withheld.chance == 0.55
    other = doubt_of(track(0.8, could_be=["B"]), sidecar())
    assert other is not None and other.words == f"may be B: {LOOSELY}"


def test_troubles_of_all_labels():
    assert troubles_of(sidecar()) == []
    (fit,) = troubles_of(sidecar(0.6))
    assert fit.startswith("The labels hold only 60% of the usual evidence: the model may be of another subject")
    unit = sidecar(figures={"doubts": ["its unit is probably m and not mm"]})
    assert troubles_of(unit) == ["Its unit is probably m and not mm."]
    assert troubles_of(sidecar(0.0, trajectories=[]))[0].startswith("No point fits the model")
    explained = sidecar(0.0, trajectories=[], figures={"doubts": ["its unit is probably m and not mm"]})
    assert troubles_of(explained) == ["Its unit is probably m and not mm."]


def test_sidecars_as_they_are_written():
    written = io._sidecar.sidecar(make_labelling(make_recording(20), ["LASI"]))
    assert troubles_of(written) == [] and any(doubt_of(row, written) for row in written["trajectories"])
