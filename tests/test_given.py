"""Files stand for the recordings and models that they hold, wherever these are asked for."""

from dataclasses import replace

import numpy as np
import pytest

from dshpm_jax import (
    Labeller,
    Settings,
    SubjectModel,
    check,
    combine_models,
    io,
    label,
    label_many,
    read,
    read_model,
    reconstruct,
    view,
)
from dshpm_jax._given import recording_of
from dshpm_jax.synthesis import person


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    io.write_c3d(person(34, "freeform", 90, subject=1, seed=5).recording, folder / "rom.c3d")
    io.write_c3d(person(34, "walking", 40, subject=1, seed=6).recording, folder / "walk.c3d")
    io.write_model(SubjectModel.from_recordings([read(folder / "rom.c3d")]), folder / "model.json")
    return folder


@pytest.mark.parametrize("way", [str, lambda path: path], ids=["text", "path"])
def test_a_model_of_files(files, way):
    known = SubjectModel.from_recordings([read(files / "rom.c3d"), read(files / "walk.c3d")])
    rom, walk = way(files / "rom.c3d"), way(files / "walk.c3d")
    for given in ([rom, walk], [read(rom), walk]):
        found = SubjectModel.from_recordings(given)
        np.testing.assert_array_equal(found.pair_mean, known.pair_mean)
    one = SubjectModel.from_recordings(rom)
    assert one.markers == SubjectModel.from_recordings(read(rom)).markers and one.sources == ("rom.c3d",)


def test_labels_of_files_are_those_of_what_they_hold(files):
    recording, model = read(files / "walk.c3d"), read_model(files / "model.json")
    known = label(recording, model)
    for given in ((str(files / "walk.c3d"), str(files / "model.json")), (files / "walk.c3d", model)):
        np.testing.assert_array_equal(label(*given).identity, known.identity)
    (many,) = label_many([files / "walk.c3d"], [files / "model.json"])
    (lone,) = label_many(str(files / "walk.c3d"), str(files / "model.json"))
    np.testing.assert_array_equal(many.identity, known.identity)
    np.testing.assert_array_equal(lone.identity, known.identity)


def test_models_of_several_subjects_as_files(files):
    model = read_model(files / "model.json")
    path = str(files / "model.json")
    for given, known in (([path, model], [model, model]), ({"anna": path, "ben": path}, {"anna": model, "ben": model})):
        assert label(files / "walk.c3d", given).model.markers == combine_models(known).markers


def test_models_of_pages_of_captures_and_of_several_subjects(files):
    path, known = str(files / "model.json"), read_model(files / "model.json")
    assert view(files / "walk.c3d", path).html == view(files / "walk.c3d", known).html
    assert combine_models({"anna": path, "ben": known}).markers == combine_models({"anna": known, "ben": known}).markers
    assert len(Labeller(path, 100.0).finish()) == 0
    with pytest.raises(ValueError, match="one model was given alone"):
        combine_models(path)


def test_check_and_reconstruct(files):
    path, model = str(files / "walk.c3d"), str(files / "model.json")
    assert check(path, model) == check(read(path), read_model(model))
    found, known = reconstruct(path, model), reconstruct(read(path), read_model(model))
    np.testing.assert_array_equal(found.rotations, known.rotations)


def test_files_are_read_as_the_settings_say_and_with_the_markers_of_the_model(files, tmp_path):
    assert "LKNE" not in recording_of(files / "walk.c3d", settings=Settings(drop=("LKNE",)))
    walk = read(files / "walk.c3d")
    named = replace(walk, labels=("LHJC", *walk.labels[1:]))
    io.write_c3d(named, tmp_path / "computed.c3d")
    assert "LHJC" not in recording_of(tmp_path / "computed.c3d")
    model = SubjectModel.from_recordings(named)
    assert "LHJC" in recording_of(tmp_path / "computed.c3d", model)


@pytest.mark.parametrize("order", [label, check, reconstruct])
def test_a_file_that_is_not_there(files, order):
    with pytest.raises(io.ReadError, match="nowhere.c3d: there is no such file"):
        order("nowhere.c3d", files / "model.json")
    with pytest.raises(io.ReadError, match="nowhere.json"):
        order(files / "walk.c3d", "nowhere.json")
