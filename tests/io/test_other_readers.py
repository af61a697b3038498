"""What we write, ezc3d and PyPI's `c3d` read alike: many frames, many points, and all that is no point."""

import warnings

import c3d
import ezc3d
import numpy as np
import pytest
from making import make_labelling, make_recording

from dshpm_jax import Recording, io


def by_c3d(path, frames=slice(None)):
    """Labels, points (frames, points, 3; NaN where the residual is negative) and analog samples."""
    with warnings.catch_warnings(), path.open("rb") as file:
        warnings.simplefilter("ignore")  # it tells of parameters that it does not expect
        reader = c3d.Reader(file)
        found = [(points, analog) for _, points, analog in reader.read_frames(copy=True)]
        labels = [label.strip() for label in reader.point_labels]
    points = np.array([row for row, _ in found])
    return labels, np.where(points[..., 3:4] < 0, np.nan, points[..., :3])[frames], [analog for _, analog in found]


def by_ezc3d(path):
    file = ezc3d.c3d(str(path))
    point = file["parameters"]["POINT"]
    labels = [n for k in ("", *range(2, 9)) for n in point.get(f"LABELS{k}", {"value": []})["value"]]
    points = file["data"]["points"][:3].transpose(2, 1, 0)
    missing = file["data"]["meta_points"]["residuals"][0].T < 0
    return labels, np.where(missing[..., None], np.nan, points), file


@pytest.fixture
def long(tmp_path):
    """70,000 frames of two points, one of them without a name, one with a gap."""
    points = np.ones((70_000, 2, 3)) + np.arange(70_000)[:, None, None] % 1000
    points[100:140, 1] = np.nan
    io.write_c3d(Recording(points, ("*1", "LASI"), 100.0), tmp_path / "long.c3d")
    return tmp_path / "long.c3d", points


@pytest.mark.slow
def test_more_frames_than_16_bits_count(tmp_path, long):
    path, points = long
    recording = io.read(path)
    io.write_labelled(make_labelling(recording, ["RASI", "LASI"]), tmp_path / "out.c3d")
    ours = io.read(tmp_path / "out.c3d")
    for labels, found in (
        (list(ours.labels), ours.points),
        by_ezc3d(tmp_path / "out.c3d")[:2],
        by_c3d(tmp_path / "out.c3d")[:2],
    ):
        assert labels[:3] == ["RASI", "LASI", "*1"]
        assert len(found) == 70_000, labels
        np.testing.assert_array_equal(found[:, 1], points[:, 1])
        np.testing.assert_array_equal(found[:, 2], points[:, 0])
        assert np.isnan(found[:, 0]).all()


def test_more_points_than_a_byte_counts(tmp_path):
    names = [f"P{k}" for k in range(299)]
    io.write_c3d(make_recording(8, [*names, "*300"]), tmp_path / "a.c3d")
    recording = io.read(tmp_path / "a.c3d")
    io.write_labelled(make_labelling(recording, names[::-1]), tmp_path / "b.c3d")
    wanted = recording.points[:, [*range(298, -1, -1), 299]]
    for labels, found, _ in (by_ezc3d(tmp_path / "b.c3d"), by_c3d(tmp_path / "b.c3d")):
        assert labels[:255] == names[::-1][:255] and (len(labels) == 255 or labels == [*names[::-1], "*300"])
        np.testing.assert_array_equal(found, wanted)


@pytest.mark.data
@pytest.mark.parametrize("name", ["pycgm-39-ghosts/Static_trial.c3d", "vicon-fullbody-52-vsk/squat.c3d"])
def test_a_round_trip_keeps_points_and_analog_samples(data, tmp_path, name):
    recording = io.read(data / name)
    markers = [n for n, named in zip(recording.labels, recording.labelled, strict=True) if named]
    io.write_labelled(make_labelling(recording, markers), tmp_path / "out.c3d")
    (_, before, analog), (labels, after, analog_after) = by_c3d(data / name), by_c3d(tmp_path / "out.c3d")
    assert [label.rpartition(":")[2] for label in labels[: len(markers)]] == markers[:255]
    columns = [recording.columns[recording.labels.index(n)] for n in markers]
    np.testing.assert_array_equal(after[:, : len(markers)], before[:, columns])
    for one, other in zip(analog, analog_after, strict=True):
        np.testing.assert_array_equal(one, other)


def test_prefixes_that_the_file_declares(tmp_path):
    """SUBJECTS:LABEL_PREFIXES need not end in a colon."""
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = ["Nick_LASI", "Nick_RASI", "*3"]
    file.add_parameter("SUBJECTS", "USES_PREFIXES", [1])
    file.add_parameter("SUBJECTS", "LABEL_PREFIXES", ["Nick_"])
    file["data"]["points"] = np.ones((4, 3, 2))
    file.write(str(tmp_path / "a.c3d"))
    assert io.read(tmp_path / "a.c3d").labels == ("LASI", "RASI", "*3")
    file["parameters"]["SUBJECTS"]["USES_PREFIXES"]["value"] = [0]
    file.write(str(tmp_path / "b.c3d"))
    assert io.read(tmp_path / "b.c3d").labels[0] == "Nick_LASI"
    file["parameters"]["SUBJECTS"]["USES_PREFIXES"]["value"] = [1]
    file["parameters"]["SUBJECTS"]["LABEL_PREFIXES"]["value"] = ["Ann_", "Ben_"]
    file["parameters"]["POINT"]["LABELS"]["value"] = ["Ann_LASI", "Ben_LASI", "*3"]
    file.write(str(tmp_path / "c.c3d"))
    assert io.read(tmp_path / "c.c3d").labels == ("Ann_LASI", "Ben_LASI", "*3")
