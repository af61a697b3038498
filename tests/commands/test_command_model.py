"""`model`: of recordings and of the subject files of capture systems."""

from commands import command
from making import make_recording

from dshpm_jax import io
from dshpm_jax._commands.model import TEMPLATES
from dshpm_jax._model_building.templates import TEMPLATES as known_templates

MARKERS = ["LASI", "RASI", "SACR"]

SUBJECT = """<KinematicModel><Skeleton><Segment NAME="Hip"><JointFree /></Segment></Skeleton><MarkerSet><Markers>
<Marker NAME="LASI" SEGMENT="Hip" POSITION="0 0 0" /><Marker NAME="RASI" SEGMENT="Hip" POSITION="240 0 0" />
<Marker NAME="SACR" SEGMENT="Hip" POSITION="120 0 -200" /></Markers></MarkerSet></KinematicModel>"""


def test_model(folder, capsys):
    status, out, err = command(capsys, "model", "walk.c3d", "-o", "new/model.json")
    assert (status, err) == (0, "") and "3 markers" in out
    assert io.read_model(folder / "new" / "model.json").markers
    assert command(capsys, "model", "walk.c3d", "-o", "new/model.json")[0] == 0  # a model gives way to a model


def test_a_subject_file_is_a_model(folder, capsys, labeller):
    (folder / "nick.vsk").write_text(SUBJECT)
    status, out, err = command(capsys, "model", "nick.vsk", "-o", "nick.json")
    assert (status, out, err) == (0, "nick.json: 3 markers in 1 segments\n", "")
    assert io.read_model(folder / "nick.json").markers == tuple(MARKERS)
    status, out, err = command(capsys, "label", "walk.c3d", "--model", "nick.vsk", "-o", "out")
    assert (status, err) == (0, "") and io.read(folder / "out" / "walk.c3d").labels[:3] == tuple(MARKERS)


def test_a_damaged_subject_file(folder, capsys):
    (folder / "nick.vsk").write_text(SUBJECT[:100])
    status, _, err = command(capsys, "model", "nick.vsk", "-o", "nick.json")
    assert status == 1 and err.count("\n") == 1 and "nick.vsk: is no XML" in err


def test_model_of_unlabelled_points(folder, capsys):
    io.write_c3d(make_recording(9, ["*1", "*2", "*3"]), folder / "raw.c3d")
    status, _, err = command(capsys, "model", "raw.c3d", "-o", "new.json")
    assert status == 1 and "raw.c3d: none of its points has a label" in err and err.count("\n") == 1


def test_model_with_a_wrong_segments_file(folder, capsys):
    (folder / "s.toml").write_text('[hip]\nmarkers = ["LASI", "NOSE"]\n')
    status, _, err = command(capsys, "model", "walk.c3d", "-o", "new.json", "--segments", "s.toml")
    assert status == 1 and "s.toml: the segment 'hip' names NOSE" in err and err.count("\n") == 1
    assert not (folder / "new.json").exists()


def test_model_with_an_unknown_template(folder, capsys):
    status, _, err = command(capsys, "model", "walk.c3d", "-o", "new.json", "--template", "octopus")
    assert status == 2 and "octopus" in err and "plug-in-gait" in err
    assert not (folder / "new.json").exists()


def test_templates_of_the_command_are_those_that_there_are():
    assert TEMPLATES == tuple(sorted(known_templates))


def test_model_of_a_folder(folder, capsys):
    (folder / "anna").mkdir()
    for seed, name in enumerate(("a", "b")):
        io.write_c3d(make_recording(60, MARKERS, seed=seed), folder / "anna" / f"{name}.c3d")
    io.write_c3d(make_recording(60, ["*1", "*2"]), folder / "anna" / "raw.c3d")
    (folder / "anna" / "bad.c3d").write_bytes(b"")
    status, out, err = command(capsys, "model", "anna", "-o", "anna/model.json", "--no-check")
    assert (status, err) == (0, "")
    for line, said in zip(
        [
            "anna/a.c3d: used",
            "anna/b.c3d: used",
            "anna/bad.c3d: not used, the file is empty; ",
            "anna: 1 recording has no label: raw.c3d",
            "anna/model.json: 3 markers in ",
        ],
        out.splitlines(),
        strict=True,
    ):
        assert said.startswith(line)
    made = io.read_model(folder / "anna" / "model.json")
    assert made.sources == ("a.c3d", "b.c3d")
    assert command(capsys, "model", "anna/a.c3d", "anna/b.c3d", "-o", "other.json")[0] == 0
    assert (folder / "other.json").read_bytes() == (folder / "anna" / "model.json").read_bytes()


def test_model_of_a_folder_without_labels(folder, capsys):
    (folder / "anna").mkdir()
    io.write_c3d(make_recording(60, ["*1", "*2"]), folder / "anna" / "raw.c3d")
    status, _, err = command(capsys, "model", "anna", "-o", "new.json")
    assert status == 1 and "anna: none of its own recordings can be used" in err and err.count("\n") == 1
    assert not (folder / "new.json").exists()


def test_a_folder_makes_a_model_alone(folder, capsys):
    (folder / "anna").mkdir()
    status, _, err = command(capsys, "model", "walk.c3d", "anna", "-o", "new.json")
    assert status == 2 and "anna: a folder makes a model alone" in err
