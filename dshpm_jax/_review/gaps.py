"""Gaps that can be filled, with what each is expected to be off, and the accepted ones in a result."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from dshpm_jax._geometry import is_seen, runs
from dshpm_jax._labelling import Labelling
from dshpm_jax._review.edits import Span
from dshpm_jax.io import write_filled

AT_ONCE = 24
"""count; used in `Gaps.errors`: gaps whose errors are told in one answer, which takes some tenths of a second."""


class Gaps:
    """The gaps of a labelling that can be filled; `ValueError` where its model cannot fill any."""

    def __init__(self, labelling: Labelling):
        from dshpm_jax._reconstruction import ExpectedErrors, reconstruct  # imports jax

        motion = reconstruct(labelling)
        self._points, mask = motion.filled().recording.points, motion.filled().mask
        markers = labelling.model.num_markers
        self.places = [
            (marker, Span(start, stop)) for marker in range(markers) for start, stop in runs(mask[:, marker])
        ]
        self._expected = ExpectedErrors(motion)

    def listed(self, accepted: Iterable[tuple[str, Span]], markers: tuple[str, ...], axes: list[int]) -> list[Any]:
        """The gaps as the page takes them; `axes` are the order of the axes there."""
        taken = {(markers.index(name), span) for name, span in accepted if name in markers}
        return [
            {
                "marker": marker,
                "first": span.first,
                "last": span.last - 1,
                "accepted": (marker, span) in taken,
                "path": np.round(self._points[span.first : span.last, marker][:, axes], 1).tolist(),
            }
            for marker, span in self.places
        ]

    def errors(self, first: int) -> list[tuple[float | None, ...]]:
        """Expected errors (mm), by the body and by a spline, of some gaps from the number `first` on."""
        return [tuple(self._expected.of(marker, *span)) for marker, span in self.places[first : first + AT_ONCE]]

    def fill(self, labelling: Labelling, accepted: Iterable[tuple[str, Span]], path: Path) -> None:
        """Puts accepted gaps into the labelled C3D file that was written of the labelling."""
        markers = labelling.model.markers
        found = labelling.to_recording()
        points, mask = found.points[:, : len(markers)].copy(), np.zeros((found.num_frames, len(markers)), bool)
        for name, span in accepted:
            if name in markers:
                mask[span.first : span.last, markers.index(name)] = True
        mask &= ~is_seen(points) & is_seen(self._points[:, : len(markers)])
        points[mask] = self._points[:, : len(markers)][mask]
        columns = tuple(range(len(markers)))
        recording = replace(found, points=points, labels=markers, source=path, columns=columns)
        if mask.any():
            write_filled(recording, mask, path)
