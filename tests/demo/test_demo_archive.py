"""The archive to try every command on is what its README says."""

import subprocess
import sys

import numpy as np
import pytest

from dshpm_jax import io
from dshpm_jax.__main__ import main
from dshpm_jax._demo import archive


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("archive")
    archive.write_archive(folder)
    return folder


def test_the_command_needs_no_jax_and_names_what_it_writes(written, tmp_path):
    code = (
        "import sys\nfrom dshpm_jax.__main__ import main\n"
        "assert main(['demo', '--archive', '-o', sys.argv[1]]) == 0\nsys.exit('jax' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path / "a")], capture_output=True, text=True)
    assert done.returncode == 0
    files = sorted(p.relative_to(written).as_posix() for p in written.rglob("*") if p.is_file())
    assert done.stdout == f"in {tmp_path / 'a'}: {', '.join(files)}\n"
    for name in files:  # the same archive every time
        assert (tmp_path / "a" / name).read_bytes() == (written / name).read_bytes()


def test_it_overwrites_nothing(tmp_path, capsys):
    (tmp_path / "mine.txt").write_text("precious")
    assert main(["demo", "--archive", "-o", str(tmp_path)]) == 1
    assert "give another folder" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]


def test_its_readme_names_every_recording(written):
    said = [line.split()[0] for line in (written / "README.txt").read_text().splitlines() if ".c3d  " in line]
    assert said and sorted(said) == sorted(p.relative_to(written).as_posix() for p in written.rglob("*.c3d"))


@pytest.mark.parametrize("name", archive.SUBJECTS)
def test_subjects_have_a_labelled_take_and_unlabelled_recordings(written, name):
    whole = io.read(written / name / "labelled.c3d")
    assert whole.labelled.all() and whole.present.all() and len(whole.labels) == archive.MARKERS
    for file in archive.UNLABELLED:
        found = io.read(written / name / file)
        assert not found.labelled.any()
        expected = (1 - archive.GAPS + archive.GHOSTS) * archive.MARKERS * found.num_frames
        assert found.present.sum() == pytest.approx(expected, rel=0.01)


def test_the_static_hardly_moves(written):
    points = io.read(written / "anna" / "static.c3d").points
    assert np.ptp(points, axis=0).max() < 100  # mm


def test_the_duet_is_of_two_who_do_not_touch(written):
    assert not io.read(written / "duet" / "duet.c3d").labelled.any()
    both = archive._duet().points[..., 1]
    assert both[:, archive.MARKERS :].min() - both[:, : archive.MARKERS].max() == pytest.approx(archive.APART)


def test_two_labels_are_exchanged_for_a_while(written):
    found = io.read(written / "ben" / "exchanged.c3d")
    steps = np.linalg.norm(np.diff(found.points, axis=0), axis=-1)
    jumps = {(found.labels[k], frame + 1) for frame, k in np.argwhere(steps > 150)}
    assert jumps == {(label, frame) for label in archive.EXCHANGED for frame in (60, 120)}


def test_the_damaged_file_says_so(written):
    with pytest.raises(io.ReadError, match="truncated"):
        io.read(written / "carl" / "damaged.c3d")
