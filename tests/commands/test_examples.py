"""Every command's `--help` ends with examples, and these are commands that it takes."""

import re
import shlex
import sys
from types import SimpleNamespace

import pytest
from commands import command

from dshpm_jax.__main__ import _parser, main
from dshpm_jax._commands import COMMANDS
from dshpm_jax._commands.examples import EXAMPLES

LINES = [(name, line) for name, text in EXAMPLES.items() for line in text.splitlines()]


def test_every_command_has_some():
    assert EXAMPLES.keys() == COMMANDS.keys()


@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_them_as_they_are(capsys, name):
    status, out, _ = command(capsys, name, "--help")
    assert status == 0 and all(f"  {line}" in out for line in EXAMPLES[name].splitlines())
    if "-o " in out:
        assert "--output" in out


@pytest.mark.parametrize(("name", "line"), LINES)
def test_they_are_understood(name, line):
    order = re.split(r" {3,}", line)[0]
    program, *arguments = shlex.split(order)
    assert program == "dshpm-jax" and arguments[0] == name
    assert _parser().parse_args(arguments).run is COMMANDS[name].run


def test_the_shell_is_told_what_could_come_next(monkeypatch):
    asked = []

    def autocomplete(parser):
        asked.append(parser.prog)
        sys.exit(0)

    monkeypatch.setitem(sys.modules, "argcomplete", SimpleNamespace(autocomplete=autocomplete))
    monkeypatch.setenv("_ARGCOMPLETE", "1")
    with pytest.raises(SystemExit):
        main(["label", "--he"])
    assert asked == ["dshpm-jax"]
