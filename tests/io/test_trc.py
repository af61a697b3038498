"""TRC files, in all the ways that programs write them."""

import numpy as np
import pytest

from dshpm_jax import io

HEAD = "PathFileType\t4\t(X/Y/Z)\twalk.trc\n"
KEYS = "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
LABELS = "Frame#\tTime\tA\t\t\tB\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
ROWS = "1\t0.00\t1\t2\t3\t4\t5\t6\n2\t0.01\t7\t8\t9\t10\t11\t12\n"
POINTS = np.arange(1.0, 13).reshape(2, 2, 3)


def text(units="mm", rate="100", frames="2", labels=LABELS, rows=ROWS):
    return HEAD + KEYS + f"{rate}\t100\t{frames}\t2\t{units}\t100\t1\t{frames}\n" + labels + rows


def read(tmp_path, content: str):
    path = tmp_path / "walk.trc"
    path.write_bytes(content.encode())
    return io.read(path)


@pytest.mark.parametrize(
    "content",
    [
        text(),
        text(rows="\n" + ROWS),
        text().replace("\n", "\r\n"),
        "\ufeff" + text(),
        text(rows=ROWS.replace("\n", "\t\n")),
        text(rows=ROWS + "\n\n"),
        text(labels=LABELS.replace("A\t\t\tB\t\t", "A\t\t\tB")),
        text(labels=LABELS.replace("A\t\t\tB\t\t", "A\tB")),
        text(labels="Frame#\tTime\tA\t\t\tB\t\t\n"),
        text(rate="100.000000", frames="2.0"),
        text().replace("\t\t\t", "\t").replace("\t", "  "),
    ],
)
def test_ways_of_writing_it(tmp_path, content):
    recording = read(tmp_path, content)
    np.testing.assert_array_equal(recording.points, POINTS)
    assert (recording.labels, recording.rate, recording.unit) == (("A", "B"), 100.0, "mm")


@pytest.mark.parametrize("unit, scale", [("mm", 1), ("cm", 10), ("m", 1000), ("", 1), ("3", 1), ("[mm]", 1)])
def test_units(tmp_path, unit, scale):
    np.testing.assert_array_equal(read(tmp_path, text(unit)).points, POINTS * scale)


@pytest.mark.parametrize(
    "rows",
    [
        "1\t0\t1\t2\t3\n2\t0.01\t7\t8\t9\t10\t11\t12\n",
        "1\t0\t1\t2\t3\t\t\t\n2\t0.01\t7\t8\t9\t10\t11\t12\n",
        "1\t0\t1\t2\t3\tnan\tNaN\tnan\n2\t0.01\t7\t8\t9\t10\t11\t12\n",
        "1\t0\t1\t2\t3\t0\t0\t0\n2\t0.01\t7\t8\t9\t10\t11\t12\n",
        "1\t0\t1\t2\t3\t4\t5\t\n2\t0.01\t7\t8\t9\t10\t11\t12\n",
    ],
)
def test_missing_points(tmp_path, rows):
    points = read(tmp_path, text(rows=rows)).points
    assert np.isnan(points[0, 1]).all() and np.isfinite(points).sum() == 9


def test_a_point_without_a_name_stays(tmp_path):
    recording = read(tmp_path, text(labels=LABELS.replace("A\t", "\t", 1)))
    assert recording.labels == ("", "B") and recording.labelled.tolist() == [False, True]


@pytest.mark.parametrize(
    "content, wrong",
    [
        ("", "the file is empty"),
        ("a,b,c\n1,2,3\n", "no TRC file"),
        (text(rate="0"), "0 frames a second"),
        (text(rate="fast"), "datarate of its header is 'fast'"),
        (text(units="inches"), "'inches'"),
        (text(rows="", frames="0"), "no frames"),
        (text(labels="Frame#\tTime\n", rows="1\t0\n2\t0.01\n"), "no points"),
        (text(rows="1\t0\t\t\t\n2\t0.01\t\n"), "not one point was seen"),
        (text(rows=ROWS.replace("11", "1l")), "line 7"),
        (text(rows=ROWS.replace("12", "12\t13")), "line 7"),
    ],
)
def test_files_that_cannot_be_read(tmp_path, content, wrong):
    with pytest.raises(io.ReadError) as caught:
        read(tmp_path, content)
    assert wrong in str(caught.value) and "\n" not in str(caught.value) and "walk.trc: " in str(caught.value)


def test_real_files(data):
    for path in sorted(data.glob("*/*.trc")):
        recording = io.read(path, drop=["!*"])
        header = path.read_text().splitlines()[2].split("\t")
        assert recording.points.shape[:2] == (int(header[2]), int(header[3]))
        assert recording.unit == header[4]
