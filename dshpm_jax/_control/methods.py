"""The methods, each one control a recording: the paper's dynamic and static schemes, and the full method."""

from typing import Any

import numpy as np

from dshpm_jax._control.decision import alternatives, ceiling_of, decide
from dshpm_jax._control.dividing import divide
from dshpm_jax._control.dynamic import identify, key_frame
from dshpm_jax._control.full import full
from dshpm_jax._control.propagation import propagate
from dshpm_jax._control.scene import Known, Scene
from dshpm_jax._control.settling import model_fit
from dshpm_jax._labelling import Reason
from dshpm_jax._model import SubjectModel
from dshpm_jax._requests import Control, Together
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import NO_MATCH

Answer = tuple[Trajectories, np.ndarray, np.ndarray, tuple[Reason, ...], dict[str, Any], np.ndarray | None]
"""The trajectories; identity, confidence and reason of each, figures of the run, and what else each could be."""


def label_control(trajectories: Trajectories, model: SubjectModel, settings: Settings) -> Control:
    """The control for one recording; returns an `Answer`."""
    scene = Scene(trajectories, model, settings)
    return (yield from {"paper": _dynamic, "static": _static, "full": _full}[settings.method](scene))


def _full(scene: Scene) -> Control:
    state, fits = yield from full(scene)
    scene, state = yield from divide(scene, state)
    fit = round(model_fit(scene, state), 4)  # as it is told, so that line and confidences agree
    identity, confidence, reason = decide(scene, state, ceiling_of(fit))
    figures = {"svd_count": fits + scene.evidence_fits, "model_fit": fit}
    return scene.trajectories, identity, confidence, reason, figures, alternatives(state, identity)


def _dynamic(scene: Scene) -> Control:
    """The paper's method: one key-frame range, then propagation both ways (sections 4.2 to 4.5)."""
    frame = key_frame(scene)
    known = yield from identify(scene, frame)
    yield from propagate(scene, known, frame)
    return _answer(scene, known)


def _static(scene: Scene) -> Control:
    """Every frame alone, without tracks (the baseline of section 5.2.1); all frames side by side."""
    parts = yield Together(tuple(_single_frame(scene, frame) for frame in range(scene.trajectories.num_frames)))
    known = Known.nothing(scene)
    for here, part in parts:
        known.identity[here], known.recruited[here] = part.identity, part.recruited
        known.found |= part.found
        known.fits += part.fits
    return _answer(scene, known)


def _single_frame(scene: Scene, frame: int) -> Control:
    here, alone = scene.trajectories.single(frame)
    known = yield from identify(Scene(alone, scene.model, scene.settings, scene.body), 0)
    return here[alone.column[0, alone.slot]], known


def _answer(scene: Scene, known: Known) -> Answer:
    """The paper accepts or abandons; it has no degrees of confidence."""
    named = known.identity != NO_MATCH
    lost = Reason.OUTSIDE if known.found.all() else Reason.ABANDONED
    given = [Reason.RECRUITED if recruited else Reason.MATCHED for recruited in known.recruited]
    reason = tuple(g if n else lost for g, n in zip(given, named))
    return scene.trajectories, known.identity, named.astype(float), reason, {"svd_count": known.fits}, None
