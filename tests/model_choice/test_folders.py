"""What of an archive is searched, and what of a folder may be labelled recordings."""

from bodies import nameless, taken, wand, write

from dshpm_jax import io
from dshpm_jax._model_choice.folders import find, folders_of, recordings_in
from dshpm_jax._reading import AS_USUAL


def test_every_folder_once_and_no_results(tmp_path):
    for name in ("anna/one", "ben", ".hidden", "labelled/anna"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "labelled" / "manifest.jsonl").write_text("")
    (tmp_path / "ben" / "back").symlink_to(tmp_path, target_is_directory=True)
    (tmp_path / "linked").symlink_to(tmp_path / "anna", target_is_directory=True)
    found = [path.relative_to(tmp_path).as_posix() for path in folders_of(tmp_path, [])]
    assert found == [".", "anna", "anna/one", "ben"]


def test_what_may_be_a_recording(tmp_path):
    write(tmp_path, b=wand(), a=wand())
    for name in ("model.json", "notes.txt", ".c.c3d", "table.csv"):
        (tmp_path / name).write_text("no,recording\n")
    (tmp_path / "folder.c3d").mkdir()
    assert [path.name for path in recordings_in(tmp_path)] == ["a.c3d", "b.c3d"]


def test_labelled_ones_are_found_and_the_others_have_a_reason(tmp_path):
    twice = wand()
    folder = write(tmp_path, good=wand(), bare=nameless(wand()), result=wand(), filled=wand())
    (folder / "filled.c3d").rename(folder / "walk.filled.c3d")
    (folder / "walk.motion.npz").write_bytes(b"")
    io.sidecar_path(folder / "result.c3d").write_text("{}")
    (folder / "bad.c3d").write_bytes(b"")
    write(folder, twice=type(twice)(twice.points, tuple("VVXYZ"), 60.0))
    found = find(folder)
    assert [r.source for r in found.labelled] == [folder / "good.c3d"] and found.unlabelled == [folder / "bare.c3d"]
    said = {path.name: why for path, why in found.left_out.items()}
    assert said.keys() == {"result.c3d", "walk.filled.c3d", "bad.c3d", "twice.c3d"}
    assert said["bad.c3d"].startswith("the file is empty") and "'V'" in said["twice.c3d"]
    assert "a result of this program" in said["result.c3d"] == said["walk.filled.c3d"]


def test_names_that_count_as_none(tmp_path):
    folder = write(tmp_path, a=wand())
    assert not find(folder, {**AS_USUAL, "unlabelled": ["?"]}).labelled


def test_takes_of_people_are_labelled(tmp_path):
    assert find(write(tmp_path, a=taken(frames=10))).labelled[0].labelled.all()
