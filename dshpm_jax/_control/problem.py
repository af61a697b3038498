"""What is to be labelled, and what is found of it once for all controls that work on it."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._control.fixed_labels import FixedLabels
from dshpm_jax._control.pair_sums import PairSums
from dshpm_jax._control.prepared_model import PreparedModel, prepared
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._geometry import evenly_spaced
from dshpm_jax._model import SubjectModel
from dshpm_jax._requests import Control, Segmentation, Target
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import Trajectories


@dataclass(eq=False)
class _KeyFrames:
    """What was found in key-frames so far, by their numbers.

    Attributes:
        seen: the trajectories and their positions.
        asked: requests for segmentation matrices, one for all controls that wait for it side by side.
        rigid: the matrices.
    """

    seen: dict[int, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    asked: dict[int, Segmentation] = field(default_factory=dict)
    rigid: dict[int, Bool[np.ndarray, "points points"]] = field(default_factory=dict)


@dataclass(eq=False)
class LabellingProblem:
    """One recording, its model, the settings and the tuning.

    Attributes:
        prepared: what follows from model, settings and tuning; shared with other recordings by default.
        fixed: labels that are given and that nothing overrules; none by default.
        relaxation: the motion relaxation interval in frames.
    """

    trajectories: Trajectories
    model: SubjectModel
    settings: Settings
    tuning: Tuning = TUNING
    prepared: PreparedModel = None  # type: ignore[assignment]
    fixed: FixedLabels = None  # type: ignore[assignment]
    relaxation: int = field(init=False)
    _key_frames: _KeyFrames = field(init=False, default_factory=_KeyFrames)

    def __post_init__(self):
        self.relaxation = max(1, round(self.settings.relaxation_seconds * self.trajectories.rate))
        self.prepared = self.prepared or prepared(self.model, self.settings, self.tuning)
        self.fixed = self.fixed or FixedLabels.none(self.trajectories)

    def of(self, trajectories: Trajectories, source: Int[np.ndarray, " trajectories"]) -> "LabellingProblem":
        """The same model, numbers and given labels for other trajectories, of which `source` each was a part."""
        fixed = FixedLabels.of(trajectories, self.fixed.identity[source], self.model.num_markers)
        return LabellingProblem(trajectories, self.model, self.settings, self.tuning, self.prepared, fixed)

    def loosened(self, factor: float) -> "LabellingProblem":
        """The same problem with all tolerances multiplied; it shares what does not depend on them."""
        looser = LabellingProblem(
            self.trajectories, self.model, self.settings, self.tuning, self.prepared.loosened(factor), self.fixed
        )
        looser._key_frames = self._key_frames
        return looser

    @property
    def targets(self) -> list[Target]:
        """The segments as the matcher sees them."""
        return self.prepared.targets

    @cached_property
    def pair_sums(self) -> PairSums:
        """The distances between all trajectories, over frames evenly spaced."""
        frames = evenly_spaced(self.trajectories.num_frames, self.tuning.max_samples, rounded=True)
        return PairSums.of(self.trajectories, frames)

    @property
    def last_frame(self) -> int:
        return self.trajectories.num_frames - 1

    def at(self, frame: int) -> tuple[Int[np.ndarray, " points"], Float[np.ndarray, "points 3"]]:
        """The trajectories seen in a key-frame and their positions, as `Trajectories.at` has them, found once."""
        if frame not in self._key_frames.seen:
            self._key_frames.seen[frame] = self.trajectories.at(frame)
        return self._key_frames.seen[frame]

    def later(self, frame: int) -> int:
        """The frame one relaxation interval on, or back where the recording ends before."""
        ahead = frame + self.relaxation
        return ahead if ahead <= self.last_frame else max(0, frame - self.relaxation)

    def window(self, frame: int) -> Int[np.ndarray, " window"]:
        """Frames K + n delta of Eq. 2, clipped at the ends of the recording.

        Our reading: near the end the window starts earlier, so that it keeps its length where it can.
        """
        steps = self.settings.window_steps
        first = max(0, min(frame, self.last_frame - steps * self.relaxation))
        return np.unique(np.minimum(first + self.relaxation * np.arange(steps + 1), self.last_frame))

    def rigid(self, frame: int) -> Control[Bool[np.ndarray, "points points"]]:
        """The segmentation matrix of the points in `frame` (Eqs. 1 and 2), made once a frame."""
        if frame not in self._key_frames.rigid:
            here, _ = self.at(frame)
            if self.settings.method == "static" or not len(here):
                self._key_frames.rigid[frame] = np.ones((len(here), len(here)), bool)
            else:
                self._key_frames.rigid[frame] = yield self._segmentation(frame, here)
        return self._key_frames.rigid[frame]

    def _segmentation(self, frame: int, here: Int[np.ndarray, " points"]) -> Segmentation:
        """The request for a frame's matrix: the same one for all controls that wait for it side by side."""
        if frame not in self._key_frames.asked:
            window = self.trajectories.positions(self.window(frame), here)
            self._key_frames.asked[frame] = Segmentation(window, *self._limits())
        return self._key_frames.asked[frame]

    def _limits(self) -> tuple[float, float]:
        """Right-hand sides of Eqs. 1 and 2: the farthest pair of any segment and the largest distortion ratio."""
        extent = max(float(t.distance.max()) for t in self.targets)
        ratio = self.settings.distortion_ratio
        return extent, max(s.distortion_ratio for s in self.model.segments) if ratio is None else ratio
