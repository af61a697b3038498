"""Reconstructed motion as a file of numpy arrays."""

import io
from pathlib import Path

import numpy as np

from dshpm_jax._reconstruction.filling import Filled
from dshpm_jax._reconstruction.motion import Motion
from dshpm_jax.io._atomic import write_whole


def write_motion(motion: Motion, path: str | Path, filled: Filled | None = None) -> None:
    """Writes a compressed NPZ file, whole or not at all; lengths are millimetres, NaN where nothing is known.

    It holds `rotations` (frames, segments, 3, 3), `translations`, `joins` (frames, segments, 3), `residual`, `found`
    (frames, segments; the numbers of `Found`), `segments` and `parents` (-1: the root), `rate` (frames a second),
    `points` (frames, columns, 3), `labels`, and `filled` (frames, columns), which of the points were not measured.

    Arguments:
        motion: what to write.
        path: the file; numpy's `load` reads it.
        filled: `motion.filled()`; without it `points` are the measured ones.
    """
    recording = motion.recording if filled is None else filled.recording
    mask = np.zeros(recording.points.shape[:2], bool) if filled is None else filled.mask
    segments = motion.model.segments
    file = io.BytesIO()
    np.savez_compressed(
        file,
        rotations=motion.rotations,
        translations=motion.translations,
        joins=motion.joins,
        residual=motion.residual,
        found=motion.found.astype(np.int8),
        segments=np.array([segment.name for segment in segments]),
        parents=np.array([segment.parent for segment in segments]),
        rate=recording.rate,
        points=recording.points,
        labels=np.array(recording.labels),
        filled=mask,
    )
    write_whole(Path(path), [file.getbuffer()])
