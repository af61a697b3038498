"""Text files as programs and people write them: other marks, words, encodings, and more or less than they say."""

import numpy as np
import pytest
from making import make_labelling
from text_files import FILES, MOTIVE, POINTS, QTM, TRC, VICON

from dshpm_jax import io

KEYS = "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"


def saved(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def trc(rows, labels="A\t\t\t", frames=3, markers=1, axes="\t\tX1\tY1\tZ1\n\n"):
    values = f"100\t100\t{frames}\t{markers}\tmm"
    return f"PathFileType\t4\t(X/Y/Z)\ta.trc\n{KEYS}{values}\nFrame#\tTime\t{labels}\n{axes}{rows}"


RAW = "1\t0.000\t1\t2\t3\t\n2\t0.010\t1\t2\t3\t4\t5\t6\t\n3\t0.020\t\n"


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_raw_points_of_a_trc_file(tmp_path, end):
    """No names and NumMarkers 0: a row has as many points as it has."""
    content = trc(RAW, labels="", markers=0, axes="\t\t\n\n").replace("\n", end)
    recording = io.read(saved(tmp_path, "a.trc", content))
    assert recording.labels == ("", "") and recording.num_frames == 3
    assert recording.present.tolist() == [[True, False], [True, True], [False, False]]
    assert recording.notes == ("it has 0 names and up to 2 points a row: those beyond have no name",)
    io.write_labelled(make_labelling(recording, ["A"], names=["A", ""]), tmp_path / "out.trc")
    assert io.read(tmp_path / "out.trc").labels == ("A", "*1")


def test_more_points_than_names(tmp_path):
    recording = io.read(saved(tmp_path, "a.trc", trc(RAW)))
    assert recording.labels == ("A", "")
    np.testing.assert_array_equal(recording.points[1], [[1, 2, 3], [4, 5, 6]])
    with pytest.raises(io.ReadError, match="line 8 has more numbers"):
        io.read(saved(tmp_path, "a.trc", trc(RAW.replace("5\t6", "5"))))


CUT = "\n".join(TRC.splitlines()[:-1]).replace("\t3\t3\tmm", "\t900\t3\tmm")


@pytest.mark.parametrize(
    "name, content, frames, said",
    [
        ("a.trc", CUT + "\n", 2, ["it announces 900 frames and ends after 2 (truncated): those are read"]),
        ("a.trc", CUT + "\n242\t2.410\t1\t2\t", 2, ["its last row, line 9, is cut off: left out", "ends after 2"]),
        ("a.trc", CUT + "\n242\t2.410\t1\t2\t3\t4\t5\t6\t19\t20\t21.2", 2, ["is cut off", "ends after 2"]),
        ("a.csv", MOTIVE.replace("Frames,3", "Frames,100"), 3, ["it announces 100 frames and ends after 3"]),
        ("a.csv", MOTIVE.replace("Frames,3", "Frames,100")[:-45], 2, ["is cut off", "ends after 2"]),
        ("a.csv", VICON[:-15], 2, ["its last row, line 8, is cut off: left out"]),
        ("a.tsv", QTM.replace("FRAMES\t3", "FRAMES\t5"), 3, ["it announces 5 frames and ends after 3"]),
    ],
)
def test_cut_files_are_read_as_far_as_they_go(tmp_path, name, content, frames, said):
    path = saved(tmp_path, name, content)
    recording = io.read(path)
    np.testing.assert_allclose(recording.points, POINTS[:frames], rtol=1e-12)
    assert len(recording.notes) == len(said)
    assert all(part in note for part, note in zip(said, recording.notes, strict=True))
    io.write_labelled(make_labelling(recording, ["LASI", "RASI"]), tmp_path / f"out{path.suffix}")
    np.testing.assert_allclose(io.read(tmp_path / f"out{path.suffix}").points[:, :3], POINTS[:frames], rtol=1e-12)


@pytest.mark.parametrize("name", FILES)
def test_whole_files_raise_no_notes(tmp_path, name):
    assert io.read(saved(tmp_path, name, FILES[name])).notes == ()
    assert io.read(saved(tmp_path, name, FILES[name].removesuffix("\n"))).notes == ()


def with_commas(content):
    """Numbers with a decimal comma, cells parted by semicolons where they were by commas."""
    return content.replace(",", ";").replace(".", ",").replace("walk,trc", "walk.trc")


@pytest.mark.parametrize("name", FILES)
def test_decimal_commas(tmp_path, name):
    recording = io.read(saved(tmp_path, name, with_commas(FILES[name])))
    np.testing.assert_allclose(recording.points, POINTS, rtol=1e-12)
    assert recording.rate == 100


def test_decimal_commas_in_quotes(tmp_path):
    content = VICON.replace("1.50", '"1,50"').replace("21.25", '"21,25"')
    np.testing.assert_array_equal(io.read(saved(tmp_path, "a.csv", content)).points, POINTS)


def test_rates_with_a_decimal_comma(tmp_path):
    content = QTM.replace("FREQUENCY\t100", "FREQUENCY\t60,00")
    assert io.read(saved(tmp_path, "a.tsv", content)).rate == 60


@pytest.mark.parametrize(
    "old, new", [("21.25", "21,25"), ("21.25", "1,021.25"), ("7\t8\t9", "7,5\t8\t9"), ("16\t17", "16,5\t17.5")]
)
def test_both_marks_in_one_file_are_refused(tmp_path, old, new):
    path = saved(tmp_path, "a.trc", TRC.replace(old, new))
    with pytest.raises(
        io.ReadError, match=r"line \d it has numbers with decimal points and others with decimal commas"
    ):
        io.read(path)


WORDS = ["NA", "N/A", "n/a", "nan", "-NaN", "-nan(ind)", "nan(snan)", "null", "NULL", "None", "-", "--", "inf", "-inf"]
WORDS += ["1.#IND", "-1.#IND", "1.#QNAN", "-1.#IND00", "1.#INF", "#N/A", ""]


@pytest.mark.parametrize("word", WORDS)
def test_words_for_missing_points(tmp_path, word):
    content = VICON.replace("4,5,6,,,", f"4,5,6,{word},{word},{word}").replace("9,,,,16", f"9,{word},{word},{word},16")
    np.testing.assert_array_equal(io.read(saved(tmp_path, "a.csv", content)).points, POINTS)


@pytest.mark.parametrize("word", ["x", "l6", "1.2.3", "missing?", "1 2"])
def test_other_words_are_refused(tmp_path, word):
    with pytest.raises(io.ReadError, match="line 7 holds something that is no number"):
        io.read(saved(tmp_path, "a.csv", VICON.replace("16,", f"{word},")))


@pytest.mark.parametrize(
    "old, new",
    [
        ("Frame#\t", "Frame #\t"),
        ("Frame#\t", "frame\t"),
        ("X1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3", "X0\tY0\tZ0\tX1\tY1\tZ1\tX2\tY2\tZ2"),
        ("X1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3", "X5\tY5\tZ5\tX6\tY6\tZ6\tX7\tY7\tZ7"),
        ("X1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3", "X\tY\tZ\tX\tY\tZ\tX\tY\tZ"),
        ("\t\tX1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3\n\n", ""),
        ("X3\tY3\tZ3\n", "X3\tY3\tZ3\n\t\tmm\tmm\tmm\n"),
        ("240\t", "  240\t"),
    ],
)
def test_heads_of_trc_files(tmp_path, old, new):
    assert old in TRC
    path = saved(tmp_path, "a.trc", TRC.replace(old, new))
    recording = io.read(path)
    np.testing.assert_array_equal(recording.points, POINTS)
    assert recording.labels == ("LASI", "RASI", "U_12")
    io.write_labelled(make_labelling(recording, ["LASI", "RASI"]), tmp_path / "out.trc")
    assert (tmp_path / "out.trc").read_text().replace("  240", "240") == TRC.replace(old, new).replace("  240", "240")


@pytest.mark.parametrize("mark", [",", ";"])
def test_trc_files_with_other_delimiters(tmp_path, mark):
    path = saved(tmp_path, "a.trc", TRC.replace("\t", mark))
    np.testing.assert_array_equal(io.read(path).points, POINTS)
    io.write_labelled(make_labelling(io.read(path), ["LASI", "RASI"]), tmp_path / "out.trc")
    assert (tmp_path / "out.trc").read_text() == TRC.replace("\t", mark)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("name", FILES)
def test_utf_16(tmp_path, name, encoding):
    path = saved(tmp_path, name, FILES[name].encode(encoding))
    recording = io.read(path)
    np.testing.assert_allclose(recording.points, POINTS, rtol=1e-12)
    assert io.may_be_recording(path)
    out = tmp_path / f"out{path.suffix}"
    io.write_labelled(make_labelling(recording, ["LASI", "RASI"]), out)
    assert out.read_bytes()[:2] == path.read_bytes()[:2]
    np.testing.assert_allclose(io.read(out).points, POINTS, rtol=1e-12)


@pytest.mark.parametrize("label", ["#", "#7", "*Unnamed_70", "Unnamed", "unnamed 3"])
def test_more_names_that_are_none(tmp_path, label):
    recording = io.read(saved(tmp_path, "a.trc", TRC.replace("U_12", label)))
    assert recording.labelled.tolist() == [True, True, False]


def with_residuals(head=True):
    lines = QTM.splitlines()
    if not head:
        del lines[11]
    for k in range(11, len(lines)):
        cells = lines[k].split("\t")
        end = "Residual" if cells[0] == "Frame" else f"0.{k}"
        rows = [[*cells[c : c + 3], f"{cells[c][:-1]}{end}" if cells[0] == "Frame" else end] for c in (2, 5, 8)]
        lines[k] = "\t".join(cells[:2] + [cell for row in rows for cell in row])
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("head", [True, False])
def test_residual_columns_of_qtm(tmp_path, head):
    """They are no coordinates, and go with their points."""
    path = saved(tmp_path, "a.tsv", with_residuals(head))
    recording = io.read(path)
    np.testing.assert_array_equal(recording.points, POINTS)
    io.write_labelled(make_labelling(recording, ["RASI", "LASI"]), tmp_path / "out.tsv")
    lines = (tmp_path / "out.tsv").read_text().splitlines()
    last = lines[-1].split("\t")
    assert last[2:10] == ["4", "5", "6", last[5], "1", "2", "3", last[9]] and last[5].startswith("0.")
    if head:
        assert lines[11].split("\t")[2:7] == ["RASI X", "RASI Y", "RASI Z", "RASI Residual", "LASI X"]


def test_rigid_bodies_of_qtm_are_no_markers(tmp_path):
    content = (
        "NO_OF_FRAMES\t1\nNO_OF_BODIES\t1\nFREQUENCY\t100\nDATA_INCLUDED\t6D\nBODY_NAMES\tWand\n1\t2\t3\t0\t0\t0\n"
    )
    path = saved(tmp_path, "a.tsv", content)
    assert io.may_be_recording(path)  # so that a run over its folder says why it is passed over
    with pytest.raises(io.NoPoints, match="it holds 6D data, which are places of rigid bodies, no markers"):
        io.read(path)


def test_systems_before_motive_are_named(tmp_path):
    content = "comment,**********\ninfo,version,1.01\ninfo,framecount,2\nframe,1,0.0,1,2,3\n"
    with pytest.raises(io.ReadError, match="of a system before Motive"):
        io.read(saved(tmp_path, "a.csv", content))


@pytest.mark.parametrize("unit, length", [("mete", 1000), ("millim", 1), ("Centi", 10), ("MET", 1000), ("mm", 1)])
def test_units_that_were_cut_off(tmp_path, unit, length):
    recording = io.read(saved(tmp_path, "a.trc", TRC.replace("\tmm\t", f"\t{unit}\t")))
    np.testing.assert_array_equal(recording.points, POINTS * length)


@pytest.mark.parametrize("unit", ["me", "mi", "c", "metric", "inch"])
def test_units_that_may_mean_several(tmp_path, unit):
    with pytest.raises(io.ReadError, match=f"its length unit is '{unit}'"):
        io.read(saved(tmp_path, "a.trc", TRC.replace("\tmm\t", f"\t{unit}\t")))


@pytest.mark.parametrize("prefix", ["Daphnee:", "RigidBody:"])
def test_prefixes_and_numbers_of_the_system_come_back(tmp_path, prefix):
    """A marker that the file did not have gets the prefix of all others, and a new column a number that is free."""
    content = VICON.replace("Nick:", prefix).replace("*12", "*1")
    recording = io.read(saved(tmp_path, "a.csv", content))
    names = ["SACR", "", "*1", "RASI", "RASI"]
    io.write_labelled(make_labelling(recording, ["RASI", "SACR"], names=names), tmp_path / "out.csv")
    above = (tmp_path / "out.csv").read_text().splitlines()[2].split(",")[2::3]
    assert above[:2] == [f"{prefix}RASI", f"{prefix}SACR"]
    assert sorted(above[2:]) == ["*1", "*2"]


def test_two_subjects_keep_their_own_prefixes(tmp_path):
    content = VICON.replace("Nick:RASI", "box:LEFT")
    recording = io.read(saved(tmp_path, "a.csv", content))
    io.write_labelled(make_labelling(recording, ["LEFT", "LASI", "NEW"]), tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_text().splitlines()[2].split(",")[2::3] == [
        "box:LEFT",
        "Nick:LASI",
        "NEW",
        "*12",
    ]
