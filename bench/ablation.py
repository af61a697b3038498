"""What each part of the full method is worth: mean F1 with one part after the other left out.

    python bench/ablation.py ARCHIVE TRUTH [--only REGEX]

ARCHIVE holds unlabelled recordings below folders with a `model.json`, TRUTH an .npz for each, as `reliability.py` reads
them. The recordings are labelled in this process, once with everything and once for each part.
"""

import argparse
import re
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
from _truth import f1, name_of

from dshpm_jax import Settings, label_many, read, read_model
from dshpm_jax._columns import unbroken_columns
from dshpm_jax._control.full.assignment import assign_labels
from dshpm_jax._control.tuning import TUNING, Tuning
from dshpm_jax._types import NO_MATCH


@dataclass(frozen=True)
class Part:
    """How the method is run without a part.

    Attributes:
        tuning, settings: other numbers.
        stead: functions of the package, and what stands in for each wherever it is used.
    """

    tuning: Tuning = TUNING
    settings: Settings = Settings()
    stead: dict[Callable, Callable] = field(default_factory=dict)


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
    for name, part in PARTS.items():
        start = time.perf_counter()
        with ExitStack() as stack:
            for one, other in part.stead.items():
                _replace_everywhere(stack, one, other)
            labelled = label_many(recordings, models, part.settings, tuning=part.tuning)
            scores = [f1(found, t) for found, t in zip(labelled, truths)]
        seconds = time.perf_counter() - start
        print(f"{name:40} mean F1 {np.mean(scores):.4f}  worst {min(scores):.4f}  {seconds:6.1f} s", flush=True)


def _replace_everywhere(stack: ExitStack, one: Callable, other: Callable) -> None:
    """Puts `other` in the place of a function in every module of the package that has it."""
    modules = [module for name, module in sys.modules.items() if name.startswith("dshpm_jax.")]
    holders = [module for module in modules if getattr(module, one.__name__, None) is one]
    for module in holders:
        stack.enter_context(patch.object(module, one.__name__, other))


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


NO_STAGES = {f"max_{stage}_rounds": 0 for stage in ("move", "side", "rematch", "subject", "split")}
ONE_SET = replace(TUNING, key_frame_factors=(1,))

PARTS: dict[str, Part] = {
    "everything": Part(),
    "one key-frame": Part(ONE_SET, Settings(num_key_frames=1)),
    "no second set of key-frames": Part(ONE_SET),
    "all key-frames and restarts always": Part(replace(TUNING, restart_below=np.inf, more_key_frames_below=np.inf)),
    "votes alone, no evidence of whole lives": Part(replace(TUNING, max_refine_rounds=1, **NO_STAGES)),
    "greedy instead of exact assignment": Part(stead={assign_labels: _each_its_best}),
    "no restarts": Part(replace(TUNING, restart_schedules=((0.0,),))),
    "no moves": Part(replace(TUNING, max_move_rounds=0)),
    "no sides swapped": Part(replace(TUNING, max_side_rounds=0)),
    "no segment matched again": Part(replace(TUNING, max_rematch_rounds=0)),
    "no trajectory split": Part(replace(TUNING, max_split_rounds=0)),
    "one start, however divided its votes": Part(replace(TUNING, divided_below=0.0)),
    "columns cut at gaps alone": Part(stead={unbroken_columns: _at_gaps}),
    "nothing withheld": Part(settings=Settings(min_confidence=0.0)),
}

if __name__ == "__main__":
    main()
