"""Answers what a control asks by slow numpy instead of kernels, so that control is tested without jax."""

from typing import Any

import matching_reference
import numpy as np
import reference

from dshpm_jax._requests import (
    Control,
    CountFits,
    FitPoses,
    FittedPoses,
    Gather,
    MatchSegment,
    ScoreMatch,
    Segmentation,
    SegmentMatches,
)


class FakeDriver:
    """Runs one control to its end; keeps what it asked for and counts its rigid fits.

    Arguments:
        answers: kinds of requests to functions that answer them, instead of the references.
    """

    def __init__(self, answers: dict[type, Any] | None = None):
        self.asked: list[Any] = []
        self.fits = 0
        self._answers = {MatchSegment: match, FitPoses: fit, ScoreMatch: mean_residual, Segmentation: all_rigid} | (
            answers or {}
        )

    def run(self, control: Control) -> Any:
        answer = None
        while True:
            try:
                request = control.send(answer)
            except StopIteration as stop:
                return stop.value
            if isinstance(request, Gather):
                answer = [self.run(part) for part in request.controls]
            elif isinstance(request, CountFits):
                answer = self.fits
            else:
                self.asked.append(request)
                answer = self._answers[type(request)](request)
                self.fits += request.fits(answer)

    def requests(self, kind: type) -> list[Any]:
        return [request for request in self.asked if isinstance(request, kind)]


def match(asked: MatchSegment) -> SegmentMatches:
    found, _ = matching_reference.match_segment(asked, 6, 4)
    rows = sorted(found.values(), key=lambda row: (-row.filled, row.cost, row.hypothesis))
    assigned = np.array([row.assigned for row in rows]).reshape(len(rows), len(asked.target.markers))
    names = ("matched", "error", "accepted", "fits")
    kinds = (int, float, bool, int)
    return SegmentMatches(assigned, *(np.array([getattr(r, n) for r in rows], t) for n, t in zip(names, kinds)))


def fit(asked: FitPoses) -> FittedPoses:
    found = [reference.rigid_fit(*row) for row in zip(asked.shape, asked.points, asked.weights)]
    rotation, translation, rms = (np.array(field) for field in zip(*found))
    return FittedPoses(rotation, translation, rms, np.array([rank(*row) for row in zip(asked.shape, asked.weights)]))


def mean_residual(asked: ScoreMatch) -> float:
    return float(np.mean(asked.residuals[asked.matched] / asked.scale[asked.matched]))


def rank(shape: np.ndarray, weights: np.ndarray) -> int:
    """In how many directions the weighted points spread by 12 mm or more."""
    used = shape[weights > 0]
    if len(used) < 2:
        return 0
    return int((np.linalg.svd(used - used.mean(0), compute_uv=False) >= 12 * np.sqrt(len(used))).sum())


def all_rigid(asked: Segmentation) -> np.ndarray:
    return np.ones(2 * asked.window.shape[1:2], bool)
