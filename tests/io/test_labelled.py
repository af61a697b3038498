"""Labelled files: labels and the order of columns change, and nothing else."""

import ezc3d
import numpy as np
import pytest
from making import make_labelling, make_recording

from dshpm_jax import io
from dshpm_jax._recording import bare_label
from dshpm_jax._types import NO_MATCH
from dshpm_jax.io._c3d import fresh_layout
from dshpm_jax.io._c3d_format import read_layout, write_layout

C3D_FILES = [
    "pycgm-39-ghosts/Static_trial.c3d",
    "pycgm-39-ghosts/Movement_trial.c3d",
    "vicon-fullbody-52-vsk/nick_freeform_001.c3d",
    "vicon-fullbody-52-vsk/squat.c3d",
]
CHANGING = {"USED", "LABELS", "DESCRIPTIONS", "DATA_START"}


def test_markers_in_the_models_order_then_what_is_left(tmp_path):
    recording = make_recording()
    io.write_labelled(make_labelling(recording, ["SACR", "NEVER", "LASI"]), tmp_path / "a.c3d")
    back = io.read(tmp_path / "a.c3d")
    assert back.labels == ("SACR", "NEVER", "LASI", "*1", "*4")
    np.testing.assert_array_equal(back.points[:, [0, 2, 3, 4]], recording.points[:, [2, 0, 1, 3]])
    assert np.isnan(back.points[:, 1]).all()


@pytest.mark.parametrize("name", C3D_FILES)
def test_only_labels_and_columns_of_a_real_file_change(data, tmp_path, name):
    recording = io.read(data / name)
    names = [n for n, named in zip(recording.labels, recording.labelled, strict=True) if named]
    markers = sorted(names)[3:]  # three markers that the model does not know
    io.write_labelled(make_labelling(recording, markers), tmp_path / "a.c3d")

    before, after = ezc3d.c3d(str(data / name)), ezc3d.c3d(str(tmp_path / "a.c3d"))
    groups, labels = before["parameters"], after["parameters"]["POINT"]["LABELS"]["value"]
    assert [bare_label(label) for label in labels[: len(markers)]] == markers
    for group, entries in groups.items():
        for key, entry in entries.items():
            if key != "__METADATA__" and not (group == "POINT" and key in CHANGING):
                assert str(after["parameters"][group][key]) == str(entry), (group, key)
    assert after["parameters"]["POINT"]["USED"]["value"][0] == len(labels)
    np.testing.assert_array_equal(after["data"]["analogs"], before["data"]["analogs"])
    assert str(dict(after["header"]["events"])) == str(dict(before["header"]["events"]))

    # Bytes: each column that has points is there once, in coordinates, residuals and camera masks as it was.
    old, new = read_layout(data / name), read_layout(tmp_path / "a.c3d")
    assert new.analog.tobytes() == old.analog.tobytes()
    outputs = old.points.shape[1] - recording.points.shape[1]
    assert labels[len(labels) - outputs :] == [
        n for c, n in enumerate(groups["POINT"]["LABELS"]["value"]) if c not in set(recording.columns)
    ]
    count = len(labels) - outputs
    seen = sorted(old.points[t, c].tobytes() for t, c in _seen(recording))
    back = io.read(tmp_path / "a.c3d")
    assert sorted(new.points[t, c].tobytes() for t, c in _seen(back)) == seen
    assert max(back.columns) < count
    for marker in markers[:5]:
        np.testing.assert_array_equal(
            back.points[:, back.labels.index(marker)], recording.points[:, recording.labels.index(marker)]
        )


def _seen(recording):
    frames, columns = np.nonzero(recording.present)
    return [(t, recording.columns[c]) for t, c in zip(frames, columns, strict=True)]


def test_residuals_camera_masks_and_unknown_bytes_stay(tmp_path):
    recording = make_recording()
    file = fresh_layout(recording)
    rng = np.random.default_rng(3)
    words = file.points.view("<f4").reshape(20, 4, 4)
    words[..., 3] = np.where(recording.present, rng.integers(0, 32767, (20, 4)), -1)
    file.analog = rng.integers(0, 255, (20, 12), dtype=np.uint8)
    header = bytearray(file.header)
    header[4:6] = (3).to_bytes(2, "little")
    header[300:512] = rng.bytes(212)
    file.header, file.tail = bytes(header), rng.bytes(700)
    write_layout(file, tmp_path / "a.c3d")

    source = io.read(tmp_path / "a.c3d")
    io.write_labelled(make_labelling(source, ["SACR", "LASI"]), tmp_path / "b.c3d")
    old, new = read_layout(tmp_path / "a.c3d"), read_layout(tmp_path / "b.c3d")
    assert new.analog.tobytes() == old.analog.tobytes() and new.tail == old.tail
    assert new.header[300:] == old.header[300:] and new.header[18:24] == old.header[18:24]
    seen = recording.present[:, 2]
    assert (new.points[seen, 0] == old.points[seen, 2]).all()
    assert (new.points[:, 2:] == old.points[:, [1, 3]]).all()  # left as they are, missing records and all


def test_raw_points_that_change_columns(tmp_path):
    recording = make_recording(30, ["LASI", "*2", "RASI"])
    points = np.where(recording.present[..., None], recording.points, 1.0)
    swapped = points.copy()
    swapped[10:20, [0, 1]] = points[10:20, [1, 0]]
    recording = type(recording)(swapped, recording.labels, 100.0)
    links = np.tile(np.arange(3), (30, 1))
    links[[9, 19]] = [1, 0, 2]
    links[29] = NO_MATCH
    labelling = make_labelling(recording, ["LASI", "RASI"], links)
    io.write_labelled(labelling, tmp_path / "a.c3d")
    back = io.read(tmp_path / "a.c3d")
    assert back.labels == ("LASI", "RASI", "*1", "*2")
    np.testing.assert_array_equal(back.points[:, :2], points[:, [0, 2]])
    left = np.where(np.isfinite(back.points[:, 2]), back.points[:, 2], back.points[:, 3])
    np.testing.assert_array_equal(left, points[:, 1])  # in the pieces of the columns that it came in
    assert (np.isfinite(back.points[:, 2:]).all(-1).sum(1) == 1).all()


def test_two_fragments_share_a_label(tmp_path):
    recording = make_recording(10, ["a", "b"])
    points = np.ones((10, 2, 3)) * np.arange(1, 11)[:, None, None]
    points[6:, 0] = points[:6, 1] = np.nan
    recording = type(recording)(points, recording.labels, 100.0)
    io.write_labelled(make_labelling(recording, ["LASI"], names=["LASI", "LASI"]), tmp_path / "a.c3d")
    back = io.read(tmp_path / "a.c3d")
    assert back.labels == ("LASI",)
    np.testing.assert_array_equal(back.points[:, 0, 0], np.arange(1, 11))


def test_more_than_255_columns(tmp_path):
    recording = make_recording(3, [f"*{k}" for k in range(300)] + ["LASI"])
    io.write_labelled(make_labelling(recording, ["LASI"]), tmp_path / "a.c3d")
    back = io.read(tmp_path / "a.c3d")
    assert back.labels[0] == "LASI"
    assert back.present.sum() == recording.present.sum()


def test_trc_comes_out_in_its_own_unit(data, tmp_path):
    recording = io.read(data / "opencap-s4-47" / "walking1.trc")
    io.write_labelled(make_labelling(recording, sorted(recording.labels)), tmp_path / "a.c3d")
    file = ezc3d.c3d(str(tmp_path / "a.c3d"))
    assert file["parameters"]["POINT"]["UNITS"]["value"] == ["m"]
    column = recording.labels.index(min(recording.labels))
    metres = (recording.points[:, column] / 1000).astype(np.float32)
    np.testing.assert_array_equal(file["data"]["points"][:3, 0].T, metres)


def test_a_source_that_changed_is_refused(tmp_path):
    path = tmp_path / "a.c3d"
    io.write_c3d(make_recording(), path)
    labelling = make_labelling(io.read(path), ["LASI"])
    io.write_c3d(make_recording(seed=5), path)
    with pytest.raises(io.WriteError, match="other points"):
        io.write_labelled(labelling, tmp_path / "b.c3d")
    assert [p.name for p in tmp_path.iterdir()] == ["a.c3d"]


def test_never_half_a_file(tmp_path, monkeypatch):
    labelling = make_labelling(make_recording(), ["LASI"])
    (tmp_path / "a.c3d").write_bytes(b"before")

    def full_disk(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full_disk)
    with pytest.raises(OSError):
        io.write_labelled(labelling, tmp_path / "a.c3d")
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("a.c3d", b"before")]
