"""The demo: a person captured on the spot, labelled, scored and drawn."""

import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dshpm_jax import io
from dshpm_jax._demo.folder import is_free
from dshpm_jax._labelling import Labelling
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax.evaluation import Scores, precision_recall_f1, scores_by_label, trajectory_identification_rate
from dshpm_jax.synthesis import Truth, add_ghosts, open_gaps, person, scramble

FOLDER = Path("dshpm-demo")
MARKERS, RATE = 34, 60.0
MODEL_TAKE = ("freeform", 900)  # activity and frames: every joint moves
TEST_TAKE = ("running", 600)
GAPS, GHOSTS = 0.1, 0.1
SEED = 2008
TABLE_COLUMNS = 2  # labels side by side
GOOD = 0.99  # an F1 below is marked in the table


class Capture(NamedTuple):
    """A labelled take and the model from it; another take without names, and the truth about it."""

    take: Recording
    model: SubjectModel
    recording: Recording
    truth: Truth


def run(out: Path | None = None) -> int:
    """Makes, labels, scores and draws a capture; writes what it made into `out` and gives the exit status."""
    folder = FOLDER if out is None else out
    if not is_free(folder):
        return 1
    capture = _capture()
    _say_what(capture)
    labelling, first, again = _labelled(capture)
    truth = capture.truth.numbered_by(capture.model.markers)
    _say_scores(labelling, truth)
    frames = capture.recording.num_frames
    print(f"frames a second    {frames / again:8.0f}   ({frames / first:.0f} the first time, programs to be made)")
    _write(capture, labelling, folder)
    return 0


def _capture() -> Capture:
    """A labelled take for the model, and another activity of the same person with gaps, ghosts and no names."""
    rng = np.random.default_rng(SEED)
    (activity, frames), (test_activity, test_frames) = MODEL_TAKE, TEST_TAKE
    take = person(MARKERS, activity, frames, RATE, seed=SEED)
    model = SubjectModel.from_recordings([take.recording])
    test = person(MARKERS, test_activity, test_frames, RATE, seed=SEED + 1).recording
    spoilt = add_ghosts(open_gaps(test, GAPS, rng), GHOSTS, rng)
    return Capture(take.recording, model, *scramble(spoilt, rng))


def _labelled(capture: Capture) -> tuple[Labelling, float, float]:
    """The labelling, and the seconds that it took the first and the second time."""
    from dshpm_jax._label import label  # imports jax

    start = time.perf_counter()
    label(capture.recording, capture.model)
    compiled = time.perf_counter()
    labelling = label(capture.recording, capture.model)
    return labelling, compiled - start, time.perf_counter() - compiled


def _say_what(capture: Capture) -> None:
    (activity, frames), (test_activity, test_frames) = MODEL_TAKE, TEST_TAKE
    model, recording = capture.model, capture.recording
    print(
        f"model   {model.num_markers} markers in {len(model.segments)} segments, found and "
        f"learnt from {frames / RATE:.0f} s of {activity} movement\n"
        f"take    {test_frames / RATE:.0f} s of {test_activity} of the same person at {RATE:g} Hz, "
        f"{recording.points.shape[1]} trajectories without names,\n"
        f"        {GAPS:.0%} of the points lost in gaps, {GHOSTS:.0%} ghosts added\n"
        f"\nlabelling ...",
        flush=True,
    )


def _say_scores(labelling: Labelling, truth: np.ndarray) -> None:
    given = labelling.identities
    total = precision_recall_f1(given, truth)
    print(_table(scores_by_label(given, truth, labelling.model.markers)))
    print()
    for name, value in (("precision", total.precision), ("recall", total.recall), ("F1", total.f1)):
        print(f"{name:18} {value:8.2%}")
    print(f"{'trajectories':18} {trajectory_identification_rate(given, truth):8.2%}   (of markers, identified)")


def _table(scores: Mapping[str, Scores]) -> str:
    """A line a label, several labels side by side."""
    head = f"{'label':6} {'points':>6} {'precision':>9} {'recall':>7} {'F1':>6}"
    rows = [
        f"{label:6} {one.true:6d} {one.precision:9.3f} {one.recall:7.3f} {one.f1:6.3f}{' ' if one.f1 >= GOOD else '<'}"
        for label, one in scores.items()
    ]
    return _side_by_side(head + " ", rows)


def _side_by_side(head: str, rows: Sequence[str]) -> str:
    height = -(-len(rows) // TABLE_COLUMNS)
    columns = [rows[k : k + height] for k in range(0, len(rows), height)]
    lines = ["   ".join([head] * len(columns))]
    lines += ["   ".join(column[k] for column in columns if k < len(column)) for k in range(height)]
    return "\n".join(line.rstrip() for line in lines)


def _write(capture: Capture, labelling: Labelling, folder: Path) -> None:
    """Files of the demo; without matplotlib the picture is left out."""
    from dshpm_jax.report._figures import figures_png

    folder.mkdir(parents=True, exist_ok=True)
    io.write_c3d(capture.take, folder / "model-take.c3d")
    io.write_c3d(capture.recording, folder / "unlabelled.c3d")
    io.write_labelled(labelling, folder / "labelled.c3d")
    io.write_model(capture.model, folder / "model.json")
    try:
        figures_png(labelling, folder / "figures.png")
        written = "model-take.c3d, model.json, unlabelled.c3d, labelled.c3d, figures.png"
    except ModuleNotFoundError as missing:
        print(missing, file=sys.stderr)
        written = "model-take.c3d, model.json, unlabelled.c3d, labelled.c3d"
    print(f"\nin {folder}: {written}")
