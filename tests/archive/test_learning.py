"""What a model is made of again: what persons confirmed, and of other results what is sure."""

import numpy as np
import pytest
from making import make_model, make_recording
from running import MARKERS, run

from dshpm_jax import io
from dshpm_jax._archive.learning import lessons
from dshpm_jax._corrections import Correction, append, corrections_path
from dshpm_jax._messages import UsageError

RUN = "run.c3d"


@pytest.fixture
def trials(tmp_path):
    folder = tmp_path / "bob"
    folder.mkdir()
    for k, name in enumerate(("run.c3d", "walk.c3d")):
        io.write_c3d(make_recording(20 + k, seed=k), folder / name)
    io.write_model(make_model(MARKERS), folder / "model.json")
    return folder


def said(found) -> dict[str, str]:
    return {lesson.result.name: lesson.why for lesson in found}


def confirm(trials, out, name=RUN):
    append(corrections_path(out / name), Correction("confirm", whole=True), trials / name)


def test_confirmed_results_count_whole_and_others_where_they_are_sure(trials, tmp_path, labeller):
    """The labeller is sure of nothing: .875."""
    out = tmp_path / "out"
    run(trials, out)
    confirm(trials, out)
    run(trials, out)
    found = {lesson.result.name: lesson for lesson in lessons(out)}
    first, second = found[RUN], found["walk.c3d"]
    assert first.why == "confirmed" and first.recording is not None
    assert first.recording.labels == tuple(MARKERS)
    written = io.read(out / RUN)
    np.testing.assert_array_equal(first.recording.points, written.points[:, [written.labels.index(m) for m in MARKERS]])
    assert second.recording is None and second.why == "as none of its labels is sure"
    assert said(lessons(out, confirmed=True)) == {RUN: "confirmed", "walk.c3d": "as nobody has confirmed it"}


def test_results_that_are_not_as_they_were_made_do_not_count(trials, tmp_path, labeller):
    out = tmp_path / "out"
    run(trials, out)
    confirm(trials, out)
    assert "corrected since it was made" in said(lessons(out))[RUN]
    with (out / "walk.c3d").open("ab") as file:
        file.write(b"more")
    assert "another program changed it" in said(lessons(out))["walk.c3d"]
    io.sidecar_path(out / RUN).unlink()
    assert "its sidecar is not there" in said(lessons(out))[RUN]


def test_of_a_result_that_nobody_confirmed_only_sure_labels_count(trials, tmp_path, labeller):
    out = tmp_path / "out"
    run(trials, out)
    sidecar = io.sidecar_path(out / RUN)
    text = sidecar.read_text()
    assert '"label": "LASI", "confidence": 0.875' in text
    sidecar.write_text(text.replace('"label": "LASI", "confidence": 0.875', '"label": "LASI", "confidence": 0.99'))
    lesson = next(one for one in lessons(out) if one.result.name == RUN)
    assert lesson.recording is not None
    np.testing.assert_array_equal(lesson.recording.present.any(0), [name == "LASI" for name in MARKERS])


def test_folders_of_several_subjects_or_of_none_are_refused(archive, tmp_path, labeller):
    with pytest.raises(UsageError, match="holds no manifest"):
        lessons(archive)
    run(archive, tmp_path / "out")
    with pytest.raises(UsageError, match=r"several subjects \(.*ann/model.json and .*bob/model.json\)"):
        lessons(tmp_path / "out")
