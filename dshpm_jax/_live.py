"""`Labeller`: labels while the capture runs, a stated delay behind it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from dshpm_jax._control.prepared_model import prepared
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._control.uses.incremental import update_labels
from dshpm_jax._driver import Driver
from dshpm_jax._geometry import is_seen
from dshpm_jax._given import GivenModels, model_of
from dshpm_jax._model import SubjectModel
from dshpm_jax._pretracking import pretrack
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Settings
from dshpm_jax._trajectories import by_marker
from dshpm_jax._types import NO_MATCH

WINDOW = 2.0  # delays that are looked at together


@dataclass(frozen=True, eq=False)
class LabelledFrames:
    """Frames whose labels are final.

    Attributes:
        first: number of the first of them, counted from 0 since the beginning of the capture.
        points: as they were pushed (mm); columns that a block did not have are NaN.
        identities: the marker of each point, `NO_MATCH` where unlabelled or not seen.
        model: what the identities refer to.
    """

    first: int
    points: Float[np.ndarray, "frames points 3"]
    identities: Int[np.ndarray, "frames points"]
    model: SubjectModel

    def __len__(self) -> int:
        return len(self.points)

    @property
    def markers(self) -> Float[np.ndarray, "frames markers 3"]:
        """Where each marker of the model is (mm), NaN where it was not found."""
        return by_marker(self.points, self.identities, self.model.num_markers)


class Labeller:
    """Labels a capture while it runs.

    Every half delay the last two delays are looked at again: labels go on along the trajectories, what is new or lost
    is looked for, and what is older than half a delay becomes final. The labels do not depend on how the frames are cut
    into blocks.

    Arguments:
        model: of the subject, or its file; for several subjects a model of each (see `combine_models`).
        rate: frames a second (Hz).
        delay_seconds: a frame's labels come at most so long after it was pushed.
        settings: as for `label`, with the method "full".
        driver: as for `label`.

    Raises:
        ValueError: the method is another, the model is to be rescaled or has no neighbourhoods, or the delay is under
            ten frames.
    """

    def __init__(
        self,
        model: GivenModels,
        rate: float,
        delay_seconds: float = 2.0,
        settings: Settings | None = None,
        driver: Driver | None = None,
    ):
        self._settings = Settings() if settings is None else settings
        if self._settings.method != "full" or self._settings.rescale:
            raise ValueError(
                'a capture that still runs is labelled with the method "full" and the subject\'s own model'
            )
        self._step = round(delay_seconds * rate / 2)
        if self._step < 5:
            raise ValueError(f"a delay of {delay_seconds} s is under ten frames at {rate} Hz; give a longer one")
        self._model, self._rate = model_of(model), rate
        _ = prepared(self._model, self._settings, TUNING).neighbourhoods  # so that a model without any is refused now
        self._driver = Driver() if driver is None else driver
        self._keep = round(WINDOW * delay_seconds * rate)
        self._points = np.zeros((0, 0, 3))
        self._given = np.zeros((0, 0), np.int32)
        self._first = 0  # number of the first frame that is kept
        self._final = 0  # number of the first frame whose labels have not come out

    def push(self, points: Float[np.ndarray, "frames points 3"]) -> LabelledFrames:
        """Takes the next frames (mm, NaN where no point is) and gives those whose labels are final now, if any.

        Raises:
            ValueError: the array has another shape.
        """
        points = np.asarray(points, dtype=np.float64)
        if points.ndim != 3 or points.shape[-1] != 3:
            raise ValueError(f"points must have the shape (frames, points, 3), got {points.shape}")
        ready = [self._release(self._final)]
        while len(points):
            until_next = self._step - self._end % self._step
            self._append(points[:until_next])
            points = points[until_next:]
            if self._end % self._step == 0:
                self._judge()
                ready.append(self._release(self._end - self._step))
        return self._joined(ready)

    def finish(self) -> LabelledFrames:
        """The frames that are left, once the capture has ended."""
        if self._end % self._step:
            self._judge()
        return self._release(self._end)

    @property
    def _end(self) -> int:
        return self._first + len(self._points)

    def _append(self, points: np.ndarray) -> None:
        columns = max(self._points.shape[1], points.shape[1])
        self._points = np.concatenate([_widened(self._points, columns, np.nan), _widened(points, columns, np.nan)])
        fresh = np.full((len(points), columns), NO_MATCH, np.int32)
        self._given = np.concatenate([_widened(self._given, columns, NO_MATCH), fresh])

    def _judge(self) -> None:
        """Labels the frames that are kept, given the labels that they have."""
        if not is_seen(self._points).any():
            return
        columns = self._points.shape[1]
        recording = Recording(self._points, ("",) * columns, self._rate)
        tracks = pretrack(recording)
        problem = LabellingProblem(tracks, self._model, self._settings)
        final = next(self._driver.run([update_labels(problem, self._given)]))
        self._given = tracks.by_column(final.identity.astype(np.int32), columns)

    def _release(self, stop: int) -> LabelledFrames:
        """The labels of all frames before number `stop` that have not come out; forgets what is too old to matter."""
        stop = max(stop, self._final)
        rows = slice(self._final - self._first, stop - self._first)
        ready = LabelledFrames(self._final, self._points[rows].copy(), self._given[rows].copy(), self._model)
        self._final = stop
        old = max(0, min(self._final, self._end - self._keep + self._step) - self._first)
        self._points, self._given, self._first = self._points[old:], self._given[old:], self._first + old
        return ready

    def _joined(self, parts: list[LabelledFrames]) -> LabelledFrames:
        columns = self._points.shape[1]
        points = np.concatenate([_widened(part.points, columns, np.nan) for part in parts])
        identities = np.concatenate([_widened(part.identities, columns, NO_MATCH) for part in parts])
        return LabelledFrames(parts[0].first, points, identities, self._model)


def _widened(values: np.ndarray, columns: int, empty: float) -> np.ndarray:
    """The values with empty columns behind them."""
    wider = np.full((len(values), columns, *values.shape[2:]), empty, values.dtype)
    wider[:, : values.shape[1]] = values
    return wider
