"""Labels that somebody changed in a result with another program are noticed, and taken over as corrections."""

import numpy as np
import pytest
from running import run

from dshpm_jax import Recording, io
from dshpm_jax._archive.adopting import adopt, source_of, take_over
from dshpm_jax._corrections import corrections_path, read_corrections
from dshpm_jax._outcomes import KEPT

RUN = "bob/run.c3d"


@pytest.fixture
def result(archive, tmp_path, labeller):
    run(archive, tmp_path / "out")
    return tmp_path / "out" / RUN


def changed(path, change) -> None:
    """Writes the file again as another program may: fresh, and with what `change` does to points and labels."""
    found = io.read(path, frozen_gaps=False)
    points, labels = found.points.copy(), list(found.labels)
    change(points, labels)
    path.unlink()
    io.write_c3d(Recording(points, tuple(labels), found.rate, found.unit), path)


def place(labels, *names):
    return [labels.index(name) for name in names]


def exchange_two_columns_for_a_while(points, labels):
    a, b = place(labels, "LASI", "RASI")
    points[5:15, [a, b]] = points[5:15, [b, a]]


def test_what_nobody_changed_is_nothing(result):
    assert adopt(result) == []


def test_the_recording_is_that_of_the_manifest(archive, result):
    assert source_of(result) == archive / RUN


def test_labels_exchanged_for_a_while(archive, result):
    changed(result, exchange_two_columns_for_a_while)
    (correction,) = adopt(result)
    source = io.read(archive / RUN)
    said = np.full(source.points.shape[:2], "", object)
    for change in correction.changes:
        said[change.first : change.last, change.column] = f"{change.was} to {change.label}"
    seen = source.present[5:15]
    assert set(said[5:15, 0][seen[:, 0]]) == {"LASI to RASI"} and set(said[5:15, 1][seen[:, 1]]) == {"RASI to LASI"}
    said[5:15, :2] = ""
    assert (said == "").all()


def test_names_exchanged_and_a_label_taken_away(result):
    def change(points, labels):
        a, b, c = place(labels, "LASI", "RASI", "SACR")
        labels[a], labels[b], labels[c] = "RASI", "LASI", "*9"

    changed(result, change)
    (correction,) = adopt(result)
    assert {(c.was, c.label) for c in correction.changes} == {("LASI", "RASI"), ("RASI", "LASI"), ("SACR", None)}


def test_filled_gaps_and_rounded_points_are_no_corrections(result):
    def change(points, labels):
        points[np.isnan(points)] = 77.0
        points += 0.003

    changed(result, change)
    assert adopt(result) == []


def test_a_file_with_other_frames_is_refused(result):
    found = io.read(result)
    result.unlink()
    io.write_c3d(found.frames(2), result)
    with pytest.raises(io.ReadError, match="20 frames, and .* 22; put the frames back"):
        adopt(result)


def test_taken_over_they_are_kept_and_the_result_is_made_anew(archive, result, tmp_path):
    changed(result, exchange_two_columns_for_a_while)
    theirs = result.read_bytes()
    assert run(archive, tmp_path / "out", force=True)[RUN].outcome == KEPT
    assert len(take_over(result)) == 1
    found = read_corrections(corrections_path(result))
    assert found is not None and len(found.lines) == 1 and found.lines[0].by == "taken over from run.c3d"
    assert result.with_name("run.changed.c3d").read_bytes() == theirs and not result.exists()
    outcome = run(archive, tmp_path / "out")[RUN]
    assert outcome.ok and not outcome.was_there and result.exists()


def test_without_a_sidecar_there_is_nothing_to_compare_with(archive):
    with pytest.raises(io.ReadError, match="no sidecar"):
        adopt(archive / RUN)
