"""Every parameter of the method, its unit, its range and what it stands for in the paper."""

import dataclasses
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from dshpm_jax._messages import one_line

Method = Literal["full", "paper", "static"]


@dataclass(frozen=True)
class Settings:
    """How to label. Times are seconds, lengths millimetres, ratios have no unit.

    Attributes:
        method: "full" (the default: every hypothesis of several key-frames scored, learnt tolerances, trajectories
            judged by their whole life), "paper" (the dynamic scheme as published) or "static" (every frame alone,
            the baseline of section 5.2.1).
        relaxation_seconds: motion relaxation interval; the paper's 15 frames at 60 fps (section 5.1.1).
        window_steps: frames of the pre-segmentation window after its first, n = 0..10 in Eq. 2.
        key_frame_coverage: a key-frame shows at least this share of the model's markers (section 4.2).
        max_key_frame_shifts: shifts before the parent is doubted (section 4.3.2).
        distortion_ratio: overrides every segment's own (Eqs. 1 to 4); None keeps the model's.
        matching_quantity: overrides every segment's own (Eq. 5); None keeps the model's.
        quality_ratio: factor on the distortion ratio in Eq. 4 alone. Our reading: the mean residual of a rigid fit is
            well under the change of a pair distance that causes it.
        measurement_noise: floor of every distance tolerance; a relative tolerance vanishes for near markers.
        num_key_frames: key-frames from which "full" collects evidence; one for every 20 s of longer recordings.
        spread_factor: pair tolerance of "full" is the root of the sum of squares of this factor times the learnt
            spread, `tolerance_floor`, and `tolerance_ratio` times the distance.
        tolerance_floor, tolerance_ratio: see `spread_factor`.
        rescale: the model is another subject's of the same marker set; "full" first makes it fit each recording.
        min_confidence: "full" withholds labels that are less likely to be right than this.
        completeness: a file counts as partly labelled if fewer of the points that are there to be labelled have a
            label (a share; false points and markers that are not seen are not counted).
        unlabelled: names of columns that count as none, besides those that capture systems give, with the wildcards
            `*` and `?`, as in "ghost*"; see `read`.
        drop: names of columns to leave out, with wildcards, or their numbers, as in "#12"; see `read`.
        frozen_gaps: a point of a moving capture that keeps its coordinates to the last bit over several frames counts
            as missing there; see `read`.
        keep_labels: names of the file that are of markers are known labels; everything else is labelled around them.
        keep_frames: in which frames they are, the first and the last as the file numbers them; all by default.
    """

    method: Method = "full"
    # section 4.1 to 4.3
    relaxation_seconds: float = 0.25
    window_steps: int = 10
    key_frame_coverage: float = 0.9
    max_key_frame_shifts: int = 2
    distortion_ratio: float | None = None
    matching_quantity: float | None = None
    quality_ratio: float = 0.5
    measurement_noise: float = 4.0
    # beyond the paper
    num_key_frames: int = 10
    spread_factor: float = 1.5
    tolerance_floor: float = 4.0
    tolerance_ratio: float = 0.015
    rescale: bool = False
    min_confidence: float = 0.7
    completeness: float = 0.5
    unlabelled: tuple[str, ...] = ()
    drop: tuple[str, ...] = ()
    frozen_gaps: bool = True
    keep_labels: bool = False
    keep_frames: tuple[int, int] | None = None

    def __post_init__(self):
        if self.method not in ("full", "paper", "static"):
            raise ValueError(f'method is "full", "paper" or "static", not {self.method!r}')
        for name in ("rescale", "frozen_gaps", "keep_labels"):
            if not isinstance(getattr(self, name), bool):
                raise ValueError(f"{name} is true or false, not {getattr(self, name)!r}")
        if self.rescale and self.method != "full":
            raise ValueError(f'only the method "full" rescales a model, not {self.method!r}')
        for name in ("unlabelled", "drop"):
            names = getattr(self, name)
            if not isinstance(names, list | tuple) or not all(isinstance(n, str) and n for n in names):
                raise ValueError(f'{name} is a list of names such as ["ghost*"], not {names!r}')
            object.__setattr__(self, name, tuple(names))
        self._check_frames()
        for name, (low, high) in RANGES.items():
            value = getattr(self, name)
            kind = int if isinstance(_DEFAULTS[name], int) else int | float
            if value is None and _DEFAULTS[name] is None:
                continue
            if not isinstance(value, kind) or isinstance(value, bool) or not low <= value <= high:
                raise ValueError(f"{name} must lie between {low:g} and {high:g}, got {value!r}")

    def _check_frames(self) -> None:
        frames = self.keep_frames
        if frames is None:
            return
        if not (isinstance(frames, list | tuple) and len(frames) == 2 and all(type(f) is int for f in frames)):
            raise ValueError(f"keep_frames is a first and a last frame such as [1, 100], not {frames!r}")
        if not self.keep_labels or frames[1] < frames[0]:
            why = "are those of keep_labels, which is not set" if not self.keep_labels else "end before they begin"
            raise ValueError(f"keep_frames: frames {frames[0]} to {frames[1]} {why}")
        object.__setattr__(self, "keep_frames", tuple(frames))

    @classmethod
    def from_toml(cls, path: str | Path) -> "Settings":
        """Settings from the top level of a TOML file; what it does not name keeps its default."""
        try:
            found = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError) as error:
            raise ValueError(f"{path}: {one_line(f'no settings can be read: {error}')}") from None
        known = {field.name for field in dataclasses.fields(cls)}
        if unknown := sorted(found.keys() - known):
            names = one_line(", ".join(unknown), 100)
            raise ValueError(f"{path}: unknown settings {names}; known are {', '.join(sorted(known))}")
        try:
            return cls(**found)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{path}: {one_line(str(error))}") from None


RANGES = {
    "relaxation_seconds": (0.01, 10),
    "window_steps": (2, 100),
    "key_frame_coverage": (0.1, 1),
    "max_key_frame_shifts": (0, 100),
    "distortion_ratio": (0.001, 1),
    "matching_quantity": (0.1, 1),
    "quality_ratio": (0.01, 10),
    "measurement_noise": (0, 100),
    "num_key_frames": (1, 1000),
    "spread_factor": (0, 10),
    "tolerance_floor": (0.1, 100),
    "tolerance_ratio": (0, 0.5),
    "min_confidence": (0, 1),
    "completeness": (0, 1),
}

_DEFAULTS = {field.name: field.default for field in dataclasses.fields(Settings)}
