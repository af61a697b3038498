"""The takes of which golden labels are kept: what stands in each, the model that labels it, and how it is written down.

Together they go through every stage of the full method: restarts, both sets of key-frames and more starts after divided
votes, moves, exchanges of chains and of subjects, segments solved again, and trajectories that are cut.
"""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from dshpm_jax import Labelling, Recording, Settings, SubjectModel, combine_models, label
from dshpm_jax._types import NO_MATCH
from dshpm_jax.synthesis import Synthetic, add_ghosts, hand, open_gaps, person, robot_arm, scramble

FOLDER = Path(__file__).resolve().parent
CROSSING = 12  # frames that two columns take to become each other's without a leap
CAP = ("LFHD", "RFHD", "LBHD", "RBHD")

Case = tuple[Recording, SubjectModel, Settings]


def worn(recording: Recording, seed: int, gaps: float = 0.1, ghosts: float = 0.1, near: bool = False) -> Recording:
    """The recording without names, with so many points missing and false, these anywhere or near the body."""
    rng = np.random.default_rng(seed)
    return scramble(add_ghosts(open_gaps(recording, gaps, rng), ghosts, rng, near), rng)[0]


def without(recording: Recording, names: tuple[str, ...]) -> Recording:
    """The recording without the columns of these names."""
    kept = [k for k, name in enumerate(recording.labels) if name not in names]
    return Recording(recording.points[:, kept], tuple(recording.labels[k] for k in kept), recording.rate)


def beside(recordings: dict[str, Recording], apart: float) -> Recording:
    """Two takes of like length as one, the middles of the bodies so far from each other halfway (mm)."""
    (name, one), (other_name, other) = recordings.items()
    half = one.num_frames // 2
    shift = one.points[half].mean(0) - other.points[half].mean(0) + (apart, 0.0, 0.0)
    labels = [f"{n}:{marker}" for n, r in ((name, one), (other_name, other)) for marker in r.labels]
    return Recording(np.concatenate([one.points, other.points + shift], axis=1), tuple(labels), one.rate)


def crossed(recording: Recording, a: str, b: str, frame: int) -> Recording:
    """The recording in which two columns slide into each other's places around `frame`."""
    i, k = recording.labels.index(a), recording.labels.index(b)
    share = np.clip((np.arange(recording.num_frames) - frame) / CROSSING + 0.5, 0.0, 1.0)[:, None]
    points = recording.points.copy()
    points[:, i] = (1 - share) * recording.points[:, i] + share * recording.points[:, k]
    points[:, k] = (1 - share) * recording.points[:, k] + share * recording.points[:, i]
    return Recording(points, recording.labels, recording.rate)


@cache
def model_of(make: Callable[..., Synthetic], *arguments: Any, frames: int = 300, subject: int = 0) -> SubjectModel:
    return SubjectModel.from_recordings([make(*arguments, frames=frames, subject=subject, seed=1).recording])


def walking() -> Case:
    return worn(person(34, frames=90, seed=101).recording, 1), model_of(person, 34), Settings()


def freeform_hard() -> Case:
    """Chains are exchanged, and labels withheld for every reason."""
    take = person(34, "freeform", frames=90, seed=302).recording
    return worn(take, 302, 0.6, 0.5, near=True), model_of(person, 34), Settings()


def a_hand() -> Case:
    return worn(hand(frames=60, seed=103).recording, 3), model_of(hand), Settings()


def a_robot_arm() -> Case:
    return worn(robot_arm(frames=60, seed=104).recording, 4), model_of(robot_arm), Settings()


def two_people() -> Case:
    """They stand in each other, so that parts of them are exchanged."""
    takes = {name: person(34, frames=50, seed=20 + k, subject=k).recording for k, name in enumerate(("ann", "bob"))}
    models = {name: model_of(person, 34, subject=k) for k, name in enumerate(takes)}
    return worn(beside(takes, 100.0), 5), combine_models(models), Settings()


def raw_points() -> Case:
    """Columns mean nothing: points are tracked; chains are exchanged and segments solved again."""
    take = person(34, "freeform", frames=60, seed=302).recording
    spoilt = add_ghosts(open_gaps(take, 0.3, np.random.default_rng(302)), 0.3, np.random.default_rng(303), near=True)
    return scramble(spoilt, np.random.default_rng(302), trajectories=False)[0], model_of(person, 34), Settings()


def cap_not_worn() -> Case:
    """The model has four markers that nobody wears."""
    take = without(person(34, frames=60, seed=107).recording, CAP)
    return worn(take, 7), model_of(person, 34), Settings()


def model_of_one_frame() -> Case:
    """Without learnt spreads both sets of key-frames are asked, restarts lead farther, segments are solved again."""
    take = person(34, "freeform", frames=60, seed=301).recording
    return worn(take, 301, 0.3, 0.3, near=True), model_of(person, 34, frames=1), Settings()


def divided_votes() -> Case:
    """Somebody else's model of one frame: key-frames are at odds, and more of them are tried."""
    take = person(27, "freeform", frames=24, seed=400, subject=2).recording
    return worn(take, 400, 0.2, 0.5, near=True), model_of(person, 27, frames=1), Settings(num_key_frames=2)


def crossed_columns() -> Case:
    """Two trajectories become each other's and are cut."""
    take = crossed(person(34, frames=120, seed=109).recording, "LWRA", "LTHI", 50)
    return worn(take, 9, 0.0, 0.0), model_of(person, 34), Settings()


def walking_as_published() -> Case:
    return *walking()[:2], Settings(method="paper")


def robot_arm_as_published() -> Case:
    return *a_robot_arm()[:2], Settings(method="paper")


CASES: dict[str, Callable[[], Case]] = {
    make.__name__: make
    for make in (
        *(walking, freeform_hard, a_hand, a_robot_arm, two_people, raw_points, cap_not_worn, model_of_one_frame),
        *(divided_votes, crossed_columns, walking_as_published, robot_arm_as_published),
    )
}


@cache
def labelled(name: str) -> dict[str, Any]:
    """What the labeller makes of a take now, as it is written down."""
    recording, model, settings = CASES[name]()
    return written(label(recording, model, settings))


def kept(name: str) -> dict[str, Any]:
    """What is kept of it."""
    return json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))


def written(found: Labelling) -> dict[str, Any]:
    """Labels, confidences and reasons of all trajectories in their order, and the figures of the run."""
    names = [None if k == NO_MATCH else found.model.markers[k] for k in found.identity]
    rows = zip(
        found.trajectories.start.tolist(), found.trajectories.stop.tolist(), names, found.confidence, found.reason
    )
    return {
        "figures": {name: round(float(value), 4) for name, value in found.stats.items()},
        "trajectories": [
            {"frames": [start, stop - 1], "label": name, "confidence": round(float(sure), 4), "reason": reason.name}
            for start, stop, name, sure, reason in rows
        ],
    }


def as_text(found: dict[str, Any]) -> str:
    """JSON with a line a trajectory."""
    rows = ",\n".join(json.dumps(row) for row in found["trajectories"])
    return f'{{"figures": {json.dumps(found["figures"])},\n"trajectories": [\n{rows}\n]}}\n'
