"""An archive of three subjects, and a labeller that stands in for the real one."""

import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from making import make_labelling, make_model, make_recording
from running import MARKERS

from dshpm_jax import io


@pytest.fixture
def labeller(monkeypatch):
    """Stands in for the real one: a column gets the label that it carries; a rate of 13 Hz is more than it can do."""
    batches = []

    def label_many(recordings, models, settings, known):
        batches.append(len(recordings))
        for recording, model in zip(recordings, models, strict=True):
            if recording.rate == 13:
                raise RuntimeError("thirteen\nframes a second")
            yield make_labelling(recording, list(model.markers))

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
    return batches


@pytest.fixture
def archive(tmp_path) -> Path:
    """Two subjects with a model each, and a folder without one."""
    folder = tmp_path / "archive"
    for k, place in enumerate(["ann/walk.c3d", "ann/day 2/walk.C3D", "bob/run.c3d", "eve/jump.c3d"]):
        path = folder / place
        path.parent.mkdir(parents=True, exist_ok=True)
        io.write_c3d(make_recording(20 + k, seed=k), path)
    for name in ("ann", "bob"):
        io.write_model(make_model(MARKERS), folder / name / "model.json")
    (folder / "ann" / "notes.txt").write_text("no recording")
    return folder
