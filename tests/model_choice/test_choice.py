"""Which recordings a model is made of: of one body, in motion, and such as agree."""

import pytest
from bodies import exchanged, nameless, taken, wand, without, write

from dshpm_jax import SubjectModel
from dshpm_jax._model_choice import choose, compare_labels


def used(choice):
    return [recording.source.name for recording in choice.used]


def test_one_recording_is_used(tmp_path):
    choice = choose(write(tmp_path, a=taken()))
    assert used(choice) == ["a.c3d"] and list(choice.lines()) == [f"{tmp_path / 'a.c3d'}: used"]


def test_nothing_that_can_be_used(tmp_path):
    choice = choose(write(tmp_path, a=nameless(taken(frames=10)), b=nameless(taken(frames=10))))
    assert not choice.used and list(choice.lines()) == [f"{tmp_path}: 2 recordings have no label: a.c3d, b.c3d"]


def test_what_stands_still_is_left_out_beside_what_moves(tmp_path):
    choice = choose(write(tmp_path, rom=taken(), static=taken("standing")))
    assert used(choice) == ["rom.c3d"]
    said = choice.left_out[tmp_path / "static.c3d"]
    assert said.startswith("it hardly moves (") and said.endswith(" and adds no marker") and "beside rom.c3d" in said


def test_what_stands_still_is_used_where_nothing_moves_or_where_it_adds_markers(tmp_path):
    assert used(choose(write(tmp_path / "a", one=taken("standing"), two=taken("standing", 1)))) == [
        "one.c3d",
        "two.c3d",
    ]
    folder = write(tmp_path / "b", rom=without(taken(), "LKNE", "C7"), s=taken("standing"), t=taken("standing", 1))
    choice = choose(folder)
    assert used(choice) == ["rom.c3d", "s.c3d"] and choice.left_out.keys() == {folder / "t.c3d"}
    assert "for C7, LKNE; it counts little otherwise" in choice.notes[folder / "s.c3d"]
    assert {"LKNE", "C7"} <= set(SubjectModel.from_recordings(choice.used).markers)


def test_another_body_is_left_out(tmp_path):
    choice = choose(write(tmp_path, a=wand(), rom=taken(), walk=taken("walking")))
    assert used(choice) == ["rom.c3d", "walk.c3d"]
    assert choice.left_out[tmp_path / "a.c3d"].startswith("shares no markers with rom.c3d, walk.c3d: another body")


@pytest.mark.parametrize("names", ["abcd", "dcba"])
def test_a_wrong_recording_among_others_is_left_out_whatever_it_is_called(tmp_path, names):
    wrong = exchanged(taken("walking", 5), "LKNE", "LTIB")
    given = dict(zip(names, [wrong, taken(seed=1), taken("walking", 2), taken("running", 3)], strict=True))
    choice = choose(write(tmp_path, **given))
    compare_labels(choice)
    assert used(choice) == sorted(f"{name}.c3d" for name in names[1:])
    (path,) = choice.left_out
    assert path.stem == names[0] and "should be L" in choice.left_out[path] and "(1 more)" in choice.left_out[path]
    assert "frames 1-90" in choice.left_out[path] and not choice.notes


def test_of_two_that_contradict_each_other_none_is_left_out_but_it_is_said(tmp_path):
    choice = choose(write(tmp_path, a=taken(seed=1), b=exchanged(taken("walking", 5), "LKNE", "LTIB")))
    compare_labels(choice)
    assert used(choice) == ["a.c3d", "b.c3d"] and not choice.left_out
    assert "but the model of a.c3d says: " in choice.notes[tmp_path / "b.c3d"]
    assert "look which of them is right" in "".join(choice.lines())


@pytest.mark.parametrize("names", ["ab", "ba"])
def test_of_two_the_one_that_contradicts_itself_as_well_is_left_out(tmp_path, names):
    wrong = exchanged(taken("walking", 5), "LKNE", "LTIB", slice(30, 60))
    choice = choose(write(tmp_path, **dict(zip(names, [wrong, taken(seed=1)], strict=True))))
    compare_labels(choice)
    assert used(choice) == [f"{names[1]}.c3d"] and not choice.notes
    assert "frames 31-60" in choice.left_out[tmp_path / f"{names[0]}.c3d"]


def test_a_label_that_is_wrong_for_a_moment_harms_no_model(tmp_path):
    brief = exchanged(taken("walking", 5, 240), "LKNE", "LTIB", slice(50, 52))
    choice = choose(write(tmp_path, a=taken(seed=1), b=brief, c=taken("walking", 2)))
    compare_labels(choice)
    assert used(choice) == ["a.c3d", "b.c3d", "c.c3d"] and not choice.notes
