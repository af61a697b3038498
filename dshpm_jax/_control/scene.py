"""What a control knows of the recording, and what it has found so far."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float, Int

from dshpm_jax._control.body import Body, body_of
from dshpm_jax._model import SubjectModel
from dshpm_jax._requests import Control, Segmentation, Target
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import Trajectories
from dshpm_jax._types import NO_MATCH


@dataclass(eq=False)
class Scene:
    """One recording, its model and the settings, with what is computed once for all its controls.

    Attributes:
        body: what follows from model and settings; shared with other recordings by default.
        relaxation: the motion relaxation interval in frames.
        evidence_fits: rigid fits that the evidence of whole lives took so far.
    """

    trajectories: Trajectories
    model: SubjectModel
    settings: Settings
    body: Body = None  # type: ignore[assignment]
    relaxation: int = field(init=False)
    evidence_fits: int = field(init=False, default=0)
    _rigid: dict[int, Bool[np.ndarray, "points points"]] = field(init=False, default_factory=dict)
    _asked: dict[int, Segmentation] = field(init=False, default_factory=dict)
    _seen: dict[int, tuple[np.ndarray, np.ndarray]] = field(init=False, default_factory=dict)

    def __post_init__(self):
        self.relaxation = max(1, round(self.settings.relaxation_seconds * self.trajectories.rate))
        self.body = self.body or body_of(self.model, self.settings)

    @property
    def targets(self) -> list[Target]:
        """The segments as the matcher sees them."""
        return self.body.targets

    def loosened(self, factor: float) -> "Scene":
        """The same scene with all tolerances multiplied; it shares what does not depend on them."""
        scene = Scene(self.trajectories, self.model, self.settings, self.body.loosened(factor))
        scene._rigid, scene._asked, scene._seen = self._rigid, self._asked, self._seen
        return scene

    def at(self, frame: int) -> tuple[Int[np.ndarray, " points"], Float[np.ndarray, "points 3"]]:
        """The trajectories seen in a key-frame and their positions, as `Trajectories.at` has them, found once."""
        if frame not in self._seen:
            self._seen[frame] = self.trajectories.at(frame)
        return self._seen[frame]

    @property
    def last_frame(self) -> int:
        return self.trajectories.num_frames - 1

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

    def rigid(self, frame: int) -> Control:
        """The segmentation matrix of the points in `frame` (Eqs. 1 and 2), made once a frame."""
        if frame not in self._rigid:
            here, _ = self.at(frame)
            if self.settings.method == "static" or not len(here):
                self._rigid[frame] = np.ones((len(here), len(here)), bool)
            else:
                self._rigid[frame] = yield self._segmentation(frame, here)
        return self._rigid[frame]

    def _segmentation(self, frame: int, here: Int[np.ndarray, " points"]) -> Segmentation:
        """The request for a frame's matrix: the same one for all controls that wait for it side by side."""
        if frame not in self._asked:
            window = self.trajectories.positions(self.window(frame), here)
            self._asked[frame] = Segmentation(window, *self._limits())
        return self._asked[frame]

    def _limits(self) -> tuple[float, float]:
        """Right-hand sides of Eqs. 1 and 2: the farthest pair of any segment and the largest distortion ratio."""
        extent = max(float(t.distance.max()) for t in self.targets)
        ratio = self.settings.distortion_ratio
        return extent, max(s.distortion_ratio for s in self.model.segments) if ratio is None else ratio


@dataclass(eq=False)
class Known:
    """Identities found so far.

    Attributes:
        identity: the marker of each trajectory, `NO_MATCH` where unknown.
        found: which segments are identified.
        recruited: which trajectories got their identity from a predicted place, not from a match.
        fits: rigid fits asked for so far (section 5.2.3).
    """

    identity: Int[np.ndarray, " trajectories"]
    found: Bool[np.ndarray, " segments"]
    recruited: Bool[np.ndarray, " trajectories"]
    fits: int = 0

    @classmethod
    def nothing(cls, scene: Scene) -> "Known":
        return cls.of(scene, np.full(len(scene.trajectories), NO_MATCH, dtype=np.int32))

    @classmethod
    def of(cls, scene: Scene, identity: Int[np.ndarray, " trajectories"], found: bool = False) -> "Known":
        """These identities, with all segments or none of them taken for identified."""
        return cls(identity.copy(), np.full(len(scene.model.segments), found), np.zeros(len(identity), bool))

    def copy(self) -> "Known":
        return Known(self.identity.copy(), self.found.copy(), self.recruited.copy(), self.fits)

    def restore(self, earlier: "Known") -> None:
        """Back to `earlier`, but for the fits, which were spent."""
        self.identity[:], self.found[:], self.recruited[:] = earlier.identity, earlier.found, earlier.recruited

    def recruit(self, trajectory: int, marker: int) -> None:
        """Gives a trajectory the identity of the marker near whose predicted place it is."""
        self.identity[trajectory], self.recruited[trajectory] = marker, True

    def carriers(self, scene: Scene, frame: int) -> Int[np.ndarray, " markers"]:
        """The trajectory that carries each marker of the model in `frame`, or `NO_MATCH`."""
        here, _ = scene.at(frame)
        carrier = np.full(scene.model.num_markers, NO_MATCH)
        named = here[self.identity[here] != NO_MATCH]
        carrier[self.identity[named]] = named
        return carrier

    def holders(self, scene: Scene, markers: Int[np.ndarray, " markers"], frame: int) -> Int[np.ndarray, " markers"]:
        """The trajectory that carries each of `markers` in `frame`, or `NO_MATCH`."""
        return np.where(markers != NO_MATCH, self.carriers(scene, frame)[markers], NO_MATCH)

    def clashes(self, scene: Scene, trajectory: int, marker: int) -> Bool[np.ndarray, " trajectories"]:
        """Trajectories that carry `marker` during the life of `trajectory`."""
        t = scene.trajectories
        same = (self.identity == marker) & (t.start < t.stop[trajectory]) & (t.start[trajectory] < t.stop)
        same[trajectory] = False
        return same

    def places(
        self, scene: Scene, target: Target, frame: int
    ) -> tuple[Float[np.ndarray, "columns 3"], Bool[np.ndarray, " columns"]]:
        """Where the identified markers of `target` are in `frame` (mm), NaN for the others, and which are there."""
        holder = self.holders(scene, target.markers, frame)
        points = scene.trajectories.positions(np.array([frame]), holder)[0]
        return points, holder != NO_MATCH
