"""What each part of the full method is worth: mean F1 with one part after the other left out.

    python bench/ablation.py ARCHIVE TRUTH [--only REGEX]

ARCHIVE holds unlabelled recordings below folders with a `model.json`, TRUTH an .npz for each, as `reliability.py` reads
them. The recordings are labelled in this process, once with everything and once for each part.
"""

import argparse
import re
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from unittest.mock import patch

import numpy as np
from _truth import f1, name_of

from dshpm_jax import Settings, _pretracking, label_many, read, read_model
from dshpm_jax._control import full, settling, voting
from dshpm_jax._types import NO_MATCH


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("archive", type=Path)
    parser.add_argument("truth", type=Path)
    parser.add_argument("--only", default="", help="paths below ARCHIVE that count")
    arguments = parser.parse_args()
    files = [f for f in sorted(arguments.archive.rglob("*.c3d")) if re.search(arguments.only, str(f))]
    recordings = [read(file) for file in files]
    models = [read_model(file.parent / "model.json") for file in files]
    truths = [dict(np.load(arguments.truth / name_of(file, arguments.archive))) for file in files]
    next(label_many(recordings[:1], models[:1]))  # compiles
    for part, patches in PARTS.items():
        with ExitStack() as stack:
            for one in patches:
                stack.enter_context(one())
            start = time.perf_counter()
            scores = [f1(found, t) for found, t in zip(label_many(recordings, models, SETTINGS.get(part)), truths)]
            seconds = time.perf_counter() - start
        print(f"{part:40} mean F1 {np.mean(scores):.4f}  worst {min(scores):.4f}  {seconds:6.1f} s", flush=True)


def _votes_only(scene, start, frames, before=None, schedule=(0.0,)) -> Iterator:
    """`settle` that judges once and changes nothing."""
    found = yield from settling.frame_evidence(scene, frames, settling.labels_in(scene, start, frames), before)
    return settling.State.of(scene, start, frames, found)


def _each_its_best(gain, start, stop) -> np.ndarray:
    """`assign_labels` in the order of the gains: who comes later goes without."""
    identity = np.full(len(gain), NO_MATCH, np.int32)
    for flat in np.argsort(-gain, axis=None, kind="stable"):
        j, label = divmod(int(flat), gain.shape[1])
        if gain[j, label] <= 0:
            break
        held = (identity == label) & (start < stop[j]) & (start[j] < stop)
        if identity[j] == NO_MATCH and not held.any():
            identity[j] = label
    return identity


def _at_gaps(points, rate) -> np.ndarray:
    """`unbroken_columns` that trusts the columns."""
    present = np.isfinite(points).all(-1)
    steps = present & np.append(present[1:], np.zeros((1, points.shape[1]), bool), axis=0)
    return np.where(steps, np.arange(points.shape[1]), NO_MATCH)


def _replaced(module: object, name: str, value: object) -> Callable:
    return lambda: patch.object(module, name, value)


def _without(*stages: Callable) -> Callable:
    return _replaced(full, "STAGES", tuple(stage for stage in full.STAGES if stage not in stages))


PARTS: dict[str, list[Callable]] = {
    "everything": [],
    "one key-frame": [_replaced(full, "DENSER", (1,))],
    "no second set of key-frames": [_replaced(full, "DENSER", (1,))],
    "all key-frames and restarts always": [_replaced(full, "SOUND", np.inf), _replaced(full, "HELD", np.inf)],
    "votes alone, no evidence of whole lives": [
        *(_replaced(module, "settle", _votes_only) for module in (full, settling)),
        _without(*full.STAGES),
    ],
    "greedy instead of exact assignment": [_replaced(m, "assign_labels", _each_its_best) for m in (voting, settling)],
    "no restarts": [_replaced(full, "SCHEDULES", ((0.0,),))],
    "no moves": [_without(full.improve)],
    "no chains exchanged": [_without(full.turn)],
    "no segment solved again": [_without(full.resolve)],
    "columns cut at gaps alone": [_replaced(_pretracking, "unbroken_columns", _at_gaps)],
    "nothing withheld": [],
}
SETTINGS = {"one key-frame": Settings(num_key_frames=1), "nothing withheld": Settings(min_confidence=0.0)}

if __name__ == "__main__":
    main()
