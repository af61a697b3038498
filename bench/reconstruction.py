"""How true are reconstructed poses, and how far off are filled markers, beside a straight line and a spline?

    python bench/reconstruction.py [--frames N]
    python bench/reconstruction.py --model MODEL.json RECORDING... [--seconds 0.1 0.25 0.5 1]

Without recordings: poses of synthetic people against what moved them, with 0, 10 and 30 % of the points missing.
With some: gaps are cut into every labelled marker in turn, where it is seen throughout and for 0.1 s on both sides, in
a sixth of the markers at a time; everything else that the recordings lack stays lacking. Errors are mm.
"""

import argparse
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from dshpm_jax import Found, Motion, Recording, SubjectModel, read, read_model, reconstruct
from dshpm_jax.synthesis import Synthetic, open_gaps, person

ROUNDS = 4  # so many times are gaps cut into a recording for each length
SHARE = 6  # one marker in so many has a gap at the same time
MARGIN = 0.1  # s, seen on both sides of a gap


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("recordings", nargs="*", type=Path)
    parser.add_argument("--model", type=Path)
    parser.add_argument("--seconds", nargs="+", type=float, default=[0.1, 0.25, 0.5, 1.0])
    parser.add_argument("--frames", type=int, default=600)
    arguments = parser.parse_args()
    if not arguments.recordings:
        poses(arguments.frames)
    elif arguments.model:
        filling(read_model(arguments.model), arguments.recordings, arguments.seconds)
    else:
        parser.error("recordings need a --model")


def poses(frames: int) -> None:
    """A row for each kind of pose: degrees and mm between the bones that moved and their segments."""
    print(f"{'markers':>7} {'motion':>9} {'missing':>7} {'found':>12} {'share':>6} {'deg':>6} {'95 %':>6} {'mm':>6} "
          f"{'95 %':>6}")  # fmt: skip
    for markers in (34, 49):
        for activity in ("walking", "freeform"):
            take = person(markers, activity, frames, seed=1)
            model = SubjectModel.from_recordings([take.recording], segments=take.segments)
            bones = _bones(reconstruct(take.recording, model), take)
            other = person(markers, activity, frames, seed=2)
            for missing in (0.0, 0.1, 0.3):
                worn = open_gaps(other.recording, missing, np.random.default_rng(0))
                motion = reconstruct(worn, model)
                turn, shift = _apart(motion, other, bones)
                for how in sorted(Found, reverse=True):
                    here = motion.found == how
                    if here.any() and how != Found.NONE:
                        figures = [np.mean(turn[here]), np.quantile(turn[here], 0.95)]
                        figures += [np.mean(shift[here]), np.quantile(shift[here], 0.95)]
                        row = " ".join(f"{x:6.1f}" for x in figures)
                        name = how.name.lower()
                        print(
                            f"{markers:7} {activity:>9} {missing:7.0%} {name:>12} {here.mean():6.1%} {row}", flush=True
                        )


def _bones(motion: Motion, take: Synthetic) -> tuple[np.ndarray, np.ndarray]:
    """How each bone stands in the frame of its segment's shape: a turn and an origin (mm), from a whole take."""
    turned = np.einsum("fsji,fsjk->sik", motion.rotations, take.rotations)
    u, _, vt = np.linalg.svd(turned)
    origin = np.einsum("fsji,fsj->fsi", motion.rotations, take.positions - motion.translations)
    return u @ vt, np.median(origin, axis=0)


def _apart(motion: Motion, take: Synthetic, bones: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Degrees and mm between the bones as they moved and as the motion has them (frames, segments)."""
    turn, origin = bones
    between = np.einsum("fsji,fsjk,skl->fsil", take.rotations, motion.rotations, turn)
    cosine = np.clip((np.trace(between, axis1=-2, axis2=-1) - 1) / 2, -1, 1)
    placed = np.einsum("fsij,sj->fsi", motion.rotations, origin) + motion.translations
    return np.degrees(np.arccos(cosine)), np.linalg.norm(placed - take.positions, axis=-1)


def filling(model: SubjectModel, recordings: list[Path], lengths: list[float]) -> None:
    """A row for each length of gap: root mean square and median error of each way to fill."""
    print(f"{'recording':24} {'gap':>6} {'gaps':>5} " + " ".join(f"{way:>16}" for way in ("line", "spline", "ours")))
    pooled: dict[float, list[np.ndarray]] = defaultdict(list)
    for path in recordings:
        recording = read(path)
        for seconds in lengths:
            found = np.concatenate([_errors(recording, model, seconds, k) for k in range(ROUNDS)])
            if len(found):
                pooled[seconds].append(found)
                _row(path.stem, seconds, found)
    for seconds, parts in pooled.items():
        _row("all", seconds, np.concatenate(parts))


def _row(name: str, seconds: float, errors: np.ndarray) -> None:
    ways = [f"{np.sqrt((way**2).mean()):8.1f} ({np.median(way):5.1f})" for way in errors.T]
    print(f"{name[:24]:24} {seconds:4.2f} s {len(errors):5} " + " ".join(ways), flush=True)


def _errors(recording: Recording, model: SubjectModel, seconds: float, seed: int) -> np.ndarray:
    """The RMS error of each gap by line, spline and ours (gaps, 3)."""
    rng = np.random.default_rng(seed)
    length, margin = max(1, round(seconds * recording.rate)), max(2, round(MARGIN * recording.rate))
    columns = [recording.labels.index(name) for name in model.markers if name in recording.labels]
    cut, points = [], np.array(recording.points)
    for column in rng.permutation(columns)[: max(1, len(columns) // SHARE)]:
        start = int(rng.integers(margin, max(margin + 1, recording.num_frames - length - margin)))
        if np.isfinite(recording.points[start - margin : start + length + margin, column]).all():
            if start + length + margin <= recording.num_frames:
                cut.append((int(column), slice(start, start + length)))
                points[start : start + length, column] = np.nan
    filled = reconstruct(replace(recording, points=points, source=None), model).filled().recording.points
    rows = []
    for column, gap in cut:
        truth = recording.points[gap, column]
        seen = np.flatnonzero(np.isfinite(points[:, column]).all(-1))
        frames = np.arange(gap.start, gap.stop)
        line = np.stack([np.interp(frames, seen, points[seen, column, k]) for k in range(3)], axis=1)
        spline = CubicSpline(seen, points[seen, column])(frames)
        ours = filled[gap, column]
        rows.append([np.sqrt(((way - truth) ** 2).sum(-1).mean()) for way in (line, spline, ours)])
    return np.array(rows).reshape(-1, 3)


if __name__ == "__main__":
    main()
