"""Who is tested: people made on the spot with their models, or a labelled recording with a model from a file."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dshpm_jax import io
from dshpm_jax._hierarchy import choose_root
from dshpm_jax._messages import UsageError
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax.synthesis import SegmentNames, person

RATE = 60.0  # Hz, as in the paper
MODEL_ACTIVITY, MODEL_FRAMES = "freeform", 900  # what the model of a synthetic person is learnt from
DISTORTION_RATIO, RATIO_OF = 0.1, {"head": 0.05, "thigh": 0.2}  # section 5.1.1
QUANTITY_OF_SOFT, QUANTITY_OF_STIFF = 0.9, 0.8  # section 5.1.1: the softer a segment, the more of it must be found


class Subject(NamedTuple):
    """An "ideal" sequence, with the model of who is in it: every column a marker of the model."""

    recording: Recording
    model: SubjectModel


@cache
def synthetic(markers: int, activity: str, frames: int, subject: int, seed: int) -> Subject:
    """A synthetic person; the sequence and what the model is learnt from are different takes."""
    take = person(markers, activity, frames, RATE, subject, seed)
    return Subject(take.recording, _model(markers, subject, seed))


@cache
def _model(markers: int, subject: int, seed: int) -> SubjectModel:
    """The person's segments as they are, with the root of section 4.4 and the parameters of section 5.1.1."""
    take = person(markers, MODEL_ACTIVITY, MODEL_FRAMES, RATE, subject, seed + 1)
    model = SubjectModel.from_recordings([take.recording], segments=rooted(take.segments))
    segments = []
    for segment in model.segments:
        ratio = RATIO_OF.get(segment.name.split(" ")[-1], DISTORTION_RATIO)
        quantity = QUANTITY_OF_SOFT if ratio > DISTORTION_RATIO else QUANTITY_OF_STIFF
        segments.append(replace(segment, distortion_ratio=ratio, matching_quantity=quantity))
    return replace(model, segments=tuple(segments))


def rooted(segments: Mapping[str, SegmentNames]) -> dict[str, SegmentNames]:
    """The same segments, hung from the one that the paper begins with: many markers and many neighbours."""
    names = list(segments)
    parents = {name: entry["parent"] for name, entry in segments.items()}
    links = [[n for n in names if parents[n] == name or parents[name] == n] for name in names]
    place = {name: k for k, name in enumerate(names)}
    sizes = [len(entry["markers"]) for entry in segments.values()]
    here: str | None = names[choose_root(sizes, [[place[n] for n in around] for around in links])]
    below = None
    while here is not None:  # from the new root to the old one, each hangs from the one before
        above, parents[here] = parents[here], below
        here, below = above, here
    return {name: {"markers": entry["markers"], "parent": parents[name]} for name, entry in segments.items()}


def recorded(recording: Path, model: Path) -> Subject:
    """The markers of a labelled recording that its model knows; everything else in it is left out.

    Raises:
        UsageError: the recording has none of the model's markers.
        ReadError: one of the files cannot be read.
    """
    known = io.read_model(model)
    whole = io.read(recording)
    held = [k for k, label in enumerate(whole.labels) if label in known.markers]
    if not held:
        raise UsageError(f"{recording}: has none of the markers of {model}; give the model of its subject")
    labels = tuple(whole.labels[k] for k in held)
    return Subject(replace(whole, points=whole.points[:, held], labels=labels, columns=()), known)


def piece(recording: Recording, frames: int, rng: np.random.Generator) -> Recording:
    """A piece of `frames` frames from anywhere in the recording; all of it if it is no longer."""
    if recording.num_frames <= frames:
        return recording
    first = int(rng.integers(0, recording.num_frames - frames + 1))
    return recording.frames(first, first + frames)
