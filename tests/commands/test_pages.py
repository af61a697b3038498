"""`--open`: the page that was made, in the browser, if there is one."""

import pytest
from commands import command
from making import make_recording

from dshpm_jax import io


@pytest.fixture
def opened(monkeypatch):
    """Addresses that a browser was asked to show."""
    addresses = []
    monkeypatch.setattr("webbrowser.open", lambda address: addresses.append(address) or True)
    return addresses


def test_view(folder, capsys, opened):
    assert command(capsys, "view", "walk.c3d")[0] == 0 and not opened
    assert command(capsys, "view", "walk.c3d", "--open")[0] == 0
    assert command(capsys, "view", "walk.c3d", "--open", "--output", "other.html")[0] == 0
    assert opened == [(folder / name).as_uri() for name in ("walk.html", "other.html")]


def test_label_and_the_folder_of_its_results(folder, capsys, labeller, opened):
    assert command(capsys, "label", "walk.c3d", "-o", "out", "--open")[0] == 0
    assert command(capsys, "view", "out", "--open")[0] == 0
    assert opened == [(folder / "out" / "report.html").as_uri()] * 2


def test_a_page_that_could_not_be_made_is_not_shown(folder, capsys, opened):
    (folder / "bad.c3d").write_bytes(b"")
    assert command(capsys, "view", "bad.c3d", "--open")[0] == 1 and not opened


def test_a_machine_without_a_browser(folder, capsys, monkeypatch):
    monkeypatch.setattr("webbrowser.open", lambda address: False)
    io.write_c3d(make_recording(9), folder / "short.c3d")
    status, _, err = command(capsys, "view", "short.c3d", "--open")
    assert status == 0 and "short.html: found no browser" in err
