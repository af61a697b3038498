"""Results along other axes, in another unit, as TRC, and with the names that a file has."""

import itertools

import numpy as np
import pytest
from making import make_labelling, make_recording
from text_files import VICON

from dshpm_jax import Recording, io
from dshpm_jax.io import Form
from dshpm_jax.io._c3d import fresh_layout
from dshpm_jax.io._c3d_format import write_layout
from dshpm_jax.io._c3d_parameters import text_parameters, with_parameters

AXES = [
    ",".join(sign + axis for sign, axis in zip(signs, order))
    for order in itertools.permutations("xyz")
    for signs in itertools.product(["", "-"], repeat=3)
]


def column(path, label):
    return io.read(path)[label]


def test_axes_are_rotations_or_refused():
    """Of the 48 ways to name axes 24 are rotations; the others would mirror a person."""
    corner = Recording(np.eye(3)[None] * 100.0, ("x", "y", "z"), 50.0)
    turned = 0
    for axes in AXES:
        try:
            points = Form(axes=axes).of(corner).points[0] / 100
        except ValueError as error:
            assert "mirror" in str(error)
            continue
        turned += 1
        assert np.linalg.det(points) == pytest.approx(1)
        place = np.array([1.0, 2.0, 3.0])
        expected = [(-1 if part[0] == "-" else 1) * place["xyz".index(part[-1])] for part in axes.split(",")]
        np.testing.assert_array_equal(place @ points, expected)
    assert turned == 24


@pytest.mark.parametrize("wrong", [{"axes": "x,y"}, {"axes": "x,y,y"}, {"axes": "a"}, {"up": "w"}, {"unit": "inch"}])
def test_wrong_forms(wrong):
    with pytest.raises(ValueError, match="x, y and z|x, y or z|is x, y or z|must be one of"):
        Form(**wrong)
    with pytest.raises(ValueError, match="leave one of them out"):
        Form(axes="x,y,z", up="y")


@pytest.mark.parametrize("suffix", [".trc", ".c3d"])
def test_y_up_in_metres_as_opensim_wants_it(tmp_path, suffix):
    recording = make_recording()
    path = tmp_path / f"out{suffix}"
    io.write_labelled(make_labelling(recording, ["SACR", "LASI"]), path, Form(up="y", unit="m"))
    back = io.read(path)
    assert (back.unit, back.labels, back.rate) == ("m", ("SACR", "LASI", "*1", "*4"), 100.0)
    x, y, z = recording["SACR"].T
    np.testing.assert_allclose(back["SACR"].T, [x, z, -y], atol=1e-3)
    assert (back.present == make_labelling(recording, ["SACR", "LASI"]).to_recording().present).all()


@pytest.mark.parametrize(("screen", "axes"), [("+Y", ""), ("+X", "-y,x,z"), ("+Z", "x,z,-y"), ("", "x,z,-y")])
def test_the_file_may_say_what_is_up(tmp_path, screen, axes):
    file = fresh_layout(make_recording())
    file.groups = with_parameters(file.groups, "POINT", text_parameters("Y_SCREEN", [screen]))
    write_layout(file, tmp_path / "a.c3d")
    assert Form(up="y").axes_of(tmp_path / "a.c3d") == axes
    recording = io.read(tmp_path / "a.c3d")
    up = "xyz".index((screen or "+Z")[1].lower())
    np.testing.assert_array_equal(Form(up="y").of(recording)["LASI"][:, 1], recording["LASI"][:, up])


def test_a_figure_that_lies_along_another_axis_is_said():
    points = np.random.default_rng(0).normal(0, 1, (30, 9, 3)) * [200, 900, 200]
    lying = Recording(points, tuple("ABCDEFGHI"), 50.0)
    assert "z was taken for up, but the figure reaches farthest along y" in Form(up="y").doubt_of_up(lying)
    standing = Recording(points[..., [0, 2, 1]], lying.labels, 50.0)
    assert not Form(up="y").doubt_of_up(standing) and not Form(axes="x,z,-y").doubt_of_up(lying)


def test_as_it_is_nothing_is_written_anew(tmp_path):
    """A TRC file keeps the spelling of its numbers unless its axes or its unit change."""
    io.write_labelled(make_labelling(make_recording(), ["LASI"]), tmp_path / "a.trc")
    text = (tmp_path / "a.trc").read_text()
    recording = io.read(tmp_path / "a.trc")
    np.testing.assert_allclose(recording["LASI"], make_recording()["LASI"], atol=1e-5)
    io.write_labelled(make_labelling(recording, list(recording.labels[:1])), tmp_path / "b.trc")
    assert (tmp_path / "b.trc").read_text().splitlines()[5:] == text.splitlines()[5:]


def test_other_text_is_turned_as_trc_alone(tmp_path):
    (tmp_path / "a.csv").write_text(VICON)
    labelling = make_labelling(io.read(tmp_path / "a.csv"), ["LASI", "RASI"])
    with pytest.raises(io.WriteError, match="in C3D and TRC alone"):
        io.write_labelled(labelling, tmp_path / "b.csv", Form(up="y"))
    io.write_labelled(labelling, tmp_path / "b.trc", Form(up="y"))
    text = (tmp_path / "b.trc").read_text().splitlines()
    assert text[3].split("\t")[2::3] == ["Nick:LASI", "Nick:RASI", "*12"] and text[6].startswith("240\t0.000000\t1.5")


@pytest.mark.parametrize("suffix", [".c3d", ".trc"])
def test_names_come_back_as_the_file_has_them(tmp_path, suffix):
    """Prefixes and the system's numbers stay; names that the model does not know stay where that is asked for."""
    labels = ["Daphnee:LASI", "Daphnee:RASI", "Daphnee:BALL", "*7", "Daphnee:SACR"]
    io.write_c3d(make_recording(labels=labels), tmp_path / "a.c3d")
    recording = io.read(tmp_path / "a.c3d")
    tracks = make_labelling(recording, ["LASI", "SACR"])
    io.write_labelled(tracks, tmp_path / f"b{suffix}")
    io.write_labelled(tracks, tmp_path / f"c{suffix}", Form(keep_unknown=True))
    assert spelt(tmp_path / f"b{suffix}") == ["Daphnee:LASI", "Daphnee:SACR", "*1", "*2", "*7"]
    assert spelt(tmp_path / f"c{suffix}") == ["Daphnee:LASI", "Daphnee:SACR", "Daphnee:RASI", "Daphnee:BALL", "*7"]


def test_a_rejected_marker_keeps_no_name(tmp_path):
    """A column called like a marker that it was not found to be would stand beside the right one."""
    io.write_c3d(make_recording(labels=["LASI", "RASI", "BALL"]), tmp_path / "a.c3d")
    recording = io.read(tmp_path / "a.c3d")
    labelling = make_labelling(recording, ["LASI", "RASI"])
    labelling.identity[labelling.identity == 1] = -1
    io.write_labelled(labelling, tmp_path / "b.c3d", Form(keep_unknown=True))
    assert spelt(tmp_path / "b.c3d") == ["LASI", "RASI", "*1", "BALL"]


def test_filled_points_in_another_form(tmp_path):
    recording = make_recording()
    mask = ~recording.present
    points = np.where(mask[..., None], 5.0, recording.points)
    full = Recording(points, recording.labels, recording.rate)
    for name in ("a.c3d", "a.trc"):
        io.write_filled(full, mask, tmp_path / name, Form(axes="-y,x,z", unit="m"))
        back = io.read(tmp_path / name, frozen_gaps=False)
        assert back.unit == "m"
        np.testing.assert_allclose(
            back.points, np.stack([-points[..., 1], points[..., 0], points[..., 2]], -1), atol=1e-3
        )


def spelt(path):
    """The labels as they stand in the file."""
    if path.suffix == ".trc":
        return [cell for cell in path.read_text().splitlines()[3].split("\t")[2:] if cell]
    from dshpm_jax.io._c3d import raw_labels
    from dshpm_jax.io._c3d_format import read_layout

    return raw_labels(read_layout(path))
