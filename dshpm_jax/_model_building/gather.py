"""The labelled markers of several recordings, in one order."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from dshpm_jax._geometry import is_seen
from dshpm_jax._recording import Recording, check_names_apart


def gather(recordings: Sequence[Recording]) -> tuple[tuple[str, ...], list[Float[np.ndarray, "frames markers 3"]]]:
    """Names of all markers that are labelled and seen, in order of first appearance, and their points (mm).

    A marker that a recording does not have is NaN there; columns without a name are left out.
    """
    if not recordings:
        raise ValueError("a model needs at least one labelled recording, got none")
    columns = [_columns(recording) for recording in recordings]
    names = tuple(dict.fromkeys(name for found in columns for name in found))
    if not names:
        raise ValueError(
            f"no labelled marker in {', '.join(_source(r) for r in recordings)}; a model is built from recordings "
            "whose points are named"
        )
    clips = []
    for recording, found in zip(recordings, columns):
        clip = np.full((recording.num_frames, len(names), 3), np.nan)
        for i, name in enumerate(names):
            for column in found.get(name, ()):
                points = recording.points[:, column]
                clip[:, i] = np.where(is_seen(clip[:, i])[:, None], clip[:, i], points)
        clips.append(np.where(is_seen(clip)[..., None], clip, np.nan))
    return names, clips


def _columns(recording: Recording) -> dict[str, list[int]]:
    """Columns of each name that is seen at all; two columns of one name must take turns."""
    present, labelled = recording.present, recording.labelled
    found: dict[str, list[int]] = {}
    for column in np.flatnonzero(labelled & present.any(0)):
        found.setdefault(recording.labels[column], []).append(int(column))
    check_names_apart(recording)
    return found


def _source(recording: Recording) -> str:
    return recording.source.name if recording.source else "an unnamed recording"
