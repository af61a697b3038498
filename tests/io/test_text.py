"""Text files of Vicon, Motive, QTM and TRC: read alike, and written with nothing changed but labels and columns."""

import csv

import ezc3d
import numpy as np
import pytest
from making import make_labelling
from text_files import FILES, MOTIVE, POINTS, QTM, TRC, VICON, VICON_WITH_OTHERS

from dshpm_jax import io


def saved(tmp_path, name, content=None):
    path = tmp_path / name
    path.write_bytes((FILES[name] if content is None else content).encode())
    return path


@pytest.mark.parametrize("name", FILES)
def test_all_say_the_same(tmp_path, name):
    path = saved(tmp_path, name)
    recording = io.read(path)
    np.testing.assert_allclose(recording.points, POINTS, rtol=1e-12)
    assert recording.labels[:2] == ("LASI", "RASI") and recording.labelled.tolist() == [True, True, False]
    assert recording.rate == 100 and recording.unit == ("m" if "motive" in name else "mm")
    assert io.first_frame(path) == 240 and io.may_be_recording(path)


@pytest.mark.parametrize("change", ["crlf", "mark", "latin", "end", "blank lines"])
@pytest.mark.parametrize("name", FILES)
def test_ways_of_writing_them(tmp_path, name, change):
    content = FILES[name]
    raw = {
        "crlf": content.replace("\n", "\r\n").encode(),
        "mark": b"\xef\xbb\xbf" + content.encode(),
        "latin": content.replace("Nick", "N\u00edck").encode("latin-1"),
        "end": content.removesuffix("\n").encode(),
        "blank lines": (content + "\n\n").encode(),
    }[change]
    path = tmp_path / name
    path.write_bytes(raw)
    np.testing.assert_allclose(io.read(path).points, POINTS, rtol=1e-12)


def test_semicolons_and_decimal_commas(tmp_path):
    content = VICON.replace(",", ";").replace("1.50", "1,50").replace("21.25", "21,25")
    np.testing.assert_array_equal(io.read(saved(tmp_path, "vicon.csv", content)).points, POINTS)


def test_velocities_beside_the_markers_are_left_alone(tmp_path):
    wide = [",,Nick:LASI,,,,,,*12,,", "Frame,Sub Frame,X,Y,Z,X',Y',Z',X,Y,Z", ",,mm,mm,mm,mm/s,mm/s,mm/s,mm,mm,mm"]
    content = "Trajectories\n100\n" + "\n".join(wide) + "\n1,0,1,2,3,10,20,30,4,5,6\n"
    recording = io.read(saved(tmp_path, "vicon.csv", content))
    np.testing.assert_array_equal(recording.points[0], [[1, 2, 3], [4, 5, 6]])
    io.write_labelled(make_labelling(recording, ["RASI"], names=["", "RASI"]), tmp_path / "out.csv")
    lines = (tmp_path / "out.csv").read_text().splitlines()
    assert lines[2:] == [
        ",,Nick:RASI,,,*1,,,,,",
        "Frame,Sub Frame,X,Y,Z,X,Y,Z,X',Y',Z'",
        ",,mm,mm,mm,mm,mm,mm,mm/s,mm/s,mm/s",
        "1,0,4,5,6,1,2,3,10,20,30",
    ]


def without_lead():
    """QTM's file without frames and times."""
    rows = [line.split("\t") for line in QTM.splitlines()]
    return "\n".join("\t".join(row[2:] if row[0] == "Frame" or row[0].isdigit() else row) for row in rows)


@pytest.mark.parametrize(
    "content",
    [
        QTM.replace("Frame\tTime\tLASI X\tLASI Y\tLASI Z\tRASI X\tRASI Y\tRASI Z\t X\t Y\t Z\n", ""),
        without_lead(),
    ],
    ids=["no row of columns", "no frames and times"],
)
def test_qtm_without_what_is_optional(tmp_path, content):
    np.testing.assert_array_equal(io.read(saved(tmp_path, "qtm.tsv", content)).points, POINTS)


def test_motive_of_rigid_body_markers_alone(tmp_path):
    content = MOTIVE.replace(",Marker", ",Rigid Body Marker")
    np.testing.assert_allclose(io.read(saved(tmp_path, "motive.csv", content)).points, POINTS)


@pytest.mark.parametrize(
    "label",
    [
        "*12",
        "*",
        "",
        "Unlabeled 1189",
        "Unlabeled:1189",
        "Unlabelled 12",
        "unlabeled9F",
        "U_12",
        "U12",
        "New 0001",
        "1 1936",
        "Unidentified 3",
    ],
)
def test_names_that_are_none(tmp_path, label):
    recording = io.read(saved(tmp_path, "vicon.csv", VICON.replace("*12", label)))
    assert recording.labelled.tolist() == [True, True, False]


@pytest.mark.parametrize("name", FILES)
def test_a_lab_has_names_of_its_own_for_none(tmp_path, name):
    content = FILES[name].replace("LASI", "ghost 1").replace("RASI", "ghost 1")
    path = saved(tmp_path, name, content)
    assert io.read(path).labelled.tolist() == [True, True, False]
    recording = io.read(path, ["G*", "ghost ?"])
    assert recording.labels[:2] == ("", "") and not recording.labelled.any()
    np.testing.assert_array_equal(recording.points, io.read(saved(tmp_path, name, FILES[name])).points)
    saved(tmp_path, name, content)
    io.write_labelled(make_labelling(recording, []), tmp_path / f"out{path.suffix}")  # reads the file once more
    assert io.read(tmp_path / f"out{path.suffix}").points.shape == recording.points.shape


@pytest.mark.parametrize(
    "name, content, wrong",
    [
        ("a.csv", "", "the file is empty"),
        ("a.csv", "a,b,c\n1,2,3\n", "neither of Vicon"),
        ("a.csv", "Trajectories\n", "no row 'Frame"),
        ("a.csv", VICON.replace("\n100\n", "\nfast\n"), "its rate is 'fast'"),
        ("a.csv", VICON.replace("\n100\n", "\n0\n"), "0 frames a second"),
        ("a.csv", VICON.replace("\n100\n", "\n1e30\n"), "1e+30 frames a second"),
        ("a.csv", VICON.replace("mm", "furlong"), "'furlong'"),
        ("a.csv", VICON.replace("16", "l6"), "line 7 holds something that is no number"),
        ("a.csv", VICON.replace("21.25", "21.25,7"), "line 8 has more numbers"),
        ("a.csv", VICON.replace("X,Y,Z,X,Y,Z,X,Y,Z", "A,B,C"), "no points"),
        ("a.csv", "\n".join(VICON.splitlines()[:5]), "no frames"),
        ("a.csv", MOTIVE.splitlines()[0], "no rows of kinds"),
        (
            "a.csv",
            MOTIVE.replace("Frame Rate,100.000000", "Frame Rate,quick"),
            "frame rate of its first line is 'quick'",
        ),
        ("a.csv", MOTIVE.replace("Meters", "Leagues"), "'Leagues'"),
        ("a.csv", MOTIVE.replace(",Marker", ",Bone"), "no points"),
        ("a.tsv", TRC, "no TSV file of QTM"),
        ("a.tsv", QTM.replace("LASI", '"' + "a" * 200_000, 1).replace("FREQUENCY\t100", "FREQUENCY\t0"), "0 frames"),
        ("a.tsv", QTM.replace("INCLUDED\t3D", "INCLUDED\t6D"), "holds 6D data"),
        ("a.tsv", QTM.replace("FREQUENCY\t100", "FREQUENCY\t"), "FREQUENCY of its head is ''"),
        ("a.tsv", "\n".join(QTM.splitlines()[:12]).replace("FRAMES\t3", "FRAMES\t0"), "no frames"),
    ],
)
def test_files_that_cannot_be_read(tmp_path, name, content, wrong):
    path = saved(tmp_path, name, content)
    with pytest.raises(io.ReadError) as caught:
        io.read(path)
    assert wrong in str(caught.value) and "\n" not in str(caught.value) and str(caught.value).startswith(f"{path}: ")


@pytest.mark.parametrize("number", ["1e308", "-1e300", "inf", "nan", "1e12"])
def test_points_beyond_the_moon_are_missing(tmp_path, number):
    content = MOTIVE.replace("0.016,", f"{number},")
    assert not io.read(saved(tmp_path, "motive.csv", content)).present[1, 2]


def test_trajectories_far_down_are_found_and_huge_tables_do_not_fill_memory(tmp_path):
    analog = "240,0,1.5\n" * 300_000
    assert io.may_be_recording(saved(tmp_path, "a.csv", VICON_WITH_OTHERS.replace("240,0,1.5\n", analog, 1)))
    with (tmp_path / "emg.csv").open("wb") as file:
        file.truncate(8 << 30)  # no byte of it is on the disk
    assert not io.may_be_recording(tmp_path / "emg.csv")


def test_other_tables_are_no_recordings(tmp_path):
    (tmp_path / "summary.csv").write_text("output,outcome\nwalk.c3d,labelled\n")
    (tmp_path / "notes.tsv").write_text("subject\tage\n")
    assert not io.may_be_recording(tmp_path / "summary.csv") and not io.may_be_recording(tmp_path / "notes.tsv")
    assert io.may_be_recording(tmp_path / "any.c3d") and not io.may_be_recording(tmp_path / "any.txt")


@pytest.mark.parametrize("name", FILES)
def test_the_same_labels_change_no_number(tmp_path, name):
    """Every cell of the result is one of the source, in its own spelling; what is no marker stays where it was."""
    path = saved(tmp_path, name)
    recording = io.read(path)
    out = tmp_path / f"out{path.suffix}"
    io.write_labelled(make_labelling(recording, ["RASI", "NEVER", "LASI"]), out)
    back = io.read(out)
    assert back.labels[:3] == ("RASI", "NEVER", "LASI") and back.labelled.tolist() == [True] * 3 + [False]
    np.testing.assert_array_equal(back.points[:, [2, 0, 3]], recording.points)
    assert np.isnan(back.points[:, 1]).all()
    assert (back.rate, back.unit, io.first_frame(out)) == (recording.rate, recording.unit, 240)
    before, after = cells(path), cells(out)
    numbers = [sorted(cell for row in table for cell in row if cell and "0.000" != cell) for table in (before, after)]
    lost = [cell for cell in numbers[0] if cell not in numbers[1]]
    assert not [cell for cell in lost if cell[:1].isdigit()]


def cells(path):
    return list(csv.reader(path.read_text().splitlines(), delimiter="," if path.suffix == ".csv" else "\t"))


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("name", FILES)
def test_labels_in_their_own_order_give_the_very_file(tmp_path, name, end):
    """The third point is unlabelled in the source and stays so, as the system numbered it."""
    path = tmp_path / name
    path.write_bytes(FILES[name].replace("\n", end).encode())
    io.write_labelled(make_labelling(io.read(path), ["LASI", "RASI"]), tmp_path / f"out{path.suffix}")
    wanted = FILES[name].replace("\n", end)
    if "motive" in name:
        wanted = wanted.replace('"A:1"', "A:1").replace('"B:1"', "B:1").replace('"C:1"', "C:1").replace('"D:1"', "D:1")
    wanted = wanted.replace("LASI\tRASI\t" + end, "LASI\tRASI\t*1" + end).replace("\t X\t Y\t Z", "\t*1 X\t*1 Y\t*1 Z")
    assert (tmp_path / f"out{path.suffix}").read_bytes().decode() == wanted


def test_motive_keeps_its_other_columns_and_ids(tmp_path):
    path = saved(tmp_path, "motive.csv")
    io.write_labelled(make_labelling(io.read(path), ["RASI", "LASI"]), tmp_path / "out.csv")
    table = cells(tmp_path / "out.csv")
    assert table[0] == cells(path)[0]
    assert table[2][2:] == ["Rigid Body"] * 3 + ["Marker"] * 9
    assert table[3][2:] == ["Wand"] * 3 + ["Nick:RASI"] * 3 + ["Nick:LASI"] * 3 + ["Unlabeled 1189"] * 3
    assert table[4][2:] == ["A:1"] * 3 + ["C:1"] * 3 + ["B:1"] * 3 + ["D:1"] * 3
    assert table[6][:5] == ["Frame", "Time (Seconds)", "X", "Y", "Z"]
    assert table[7][2:] == ["9", "9", "9", "0.004", "0.005", "0.006", "0.0015", "0.002", "0.003", "", "", ""]


def test_another_format_than_the_sources_is_refused(tmp_path):
    labelling = make_labelling(io.read(saved(tmp_path, "vicon.csv")), ["LASI"])
    with pytest.raises(io.WriteError, match="only in the format"):
        io.write_labelled(labelling, tmp_path / "out.tsv")
    for name in ("out.c3d", "out.trc"):
        io.write_labelled(labelling, tmp_path / name)
        assert io.read(tmp_path / name).labels[0] == "LASI"


def test_a_source_that_changed_is_refused(tmp_path):
    path = saved(tmp_path, "vicon.csv")
    labelling = make_labelling(io.read(path), ["LASI"])
    path.write_text(VICON.replace("1.50", "1.75"))
    with pytest.raises(io.WriteError, match="other points"):
        io.write_labelled(labelling, tmp_path / "out.csv")
    assert not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize("name", FILES)
def test_a_mark_at_the_beginning_hides_no_recording(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(b"\xef\xbb\xbf" + FILES[name].encode())
    assert io.may_be_recording(path)


@pytest.mark.parametrize("name", FILES)
def test_frames_keep_their_numbers_as_c3d(tmp_path, name):
    io.write_labelled(make_labelling(io.read(saved(tmp_path, name)), ["LASI"]), tmp_path / "out.c3d")
    found = ezc3d.c3d(str(tmp_path / "out.c3d"))
    assert io.first_frame(tmp_path / "out.c3d") == 240 == found["header"]["points"]["first_frame"] + 1
    assert io.read(tmp_path / "out.c3d").num_frames == 3 == found["data"]["points"].shape[2]


def test_blanks_between_numbers_hide_no_gap(tmp_path):
    rows = TRC.splitlines()
    blank = [line if "\t\t\t" in line or k < 5 else line.replace("\t", " ") for k, line in enumerate(rows)]
    whole = "\n".join([*blank[:6], rows[8].replace("\t", " ")]).replace("\t3\t3\tmm", "\t1\t3\tmm")
    np.testing.assert_array_equal(io.read(saved(tmp_path, "a.trc", whole)).points, POINTS[2:])
    gap = whole.replace("\t1\t3\tmm", "\t2\t3\tmm") + "\n" + rows[7].replace("\t", " ")
    with pytest.raises(io.ReadError, match="has fewer numbers than its 3 labels need; export it with tabs"):
        io.read(saved(tmp_path, "a.trc", gap))


def test_a_last_point_of_a_trc_file_may_have_no_name(tmp_path):
    recording = io.read(saved(tmp_path, "a.trc", TRC.replace("U_12", "")))
    np.testing.assert_array_equal(recording.points, POINTS)
    assert recording.labels == ("LASI", "RASI", "")


def test_qtm_frames_in_which_nothing_was_seen_are_frames(tmp_path):
    rows = without_lead().splitlines()
    empty = "\t" * rows[-1].count("\t")
    content = "\n".join([*rows[:-3], empty, *rows[-3:], empty]).replace("FRAMES\t3", "FRAMES\t5")
    recording = io.read(saved(tmp_path, "a.tsv", content))
    np.testing.assert_array_equal(recording.points[1:4], POINTS)
    assert recording.num_frames == 5 and not recording.present[[0, 4]].any()


def test_motive_sizes_go_by_the_name_that_their_marker_has_now(tmp_path):
    rows = [row.split(",") for row in MOTIVE.splitlines()]
    for row in rows[2:]:
        row[8:8] = [row[7]] if len(row) > 8 and rows.index(row) < 7 else ["14.5"] if len(row) > 8 else []
    rows[6][8] = "Size"
    path = saved(tmp_path, "motive.csv", "\n".join(",".join(row) for row in rows) + "\n")
    exchanged = make_labelling(io.read(path), ["RASI", "LASI"], names=["RASI", "LASI", "", "LASI"])
    io.write_labelled(exchanged, tmp_path / "out.csv")
    table = cells(tmp_path / "out.csv")
    assert table[6][-1] == "Size" and table[3][-1] == "Nick:RASI" == table[3][5]
    assert table[7][-1] == "14.5"
