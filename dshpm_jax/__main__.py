# PYTHON_ARGCOMPLETE_OK
"""The command line: builds the parser, runs one command and gives its exit status."""

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from textwrap import indent

import dshpm_jax
from dshpm_jax._commands import COMMANDS
from dshpm_jax._commands.examples import EXAMPLES
from dshpm_jax._commands.statuses import INTERRUPTED, PIPE_CLOSED, WRONG_USAGE
from dshpm_jax._console import complain
from dshpm_jax._messages import UsageError


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command and gives its exit status."""
    parser = _parser()
    if "_ARGCOMPLETE" in os.environ:  # the shell asks what could come next
        import_module("argcomplete").autocomplete(parser)
    arguments = parser.parse_args(argv)
    try:
        status = arguments.run(arguments)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        return _without_reader()
    except UsageError as error:
        complain(error)
        return WRONG_USAGE
    except KeyboardInterrupt:
        complain("interrupted; what was written is whole, the same command goes on from here")
        return INTERRUPTED


def _without_reader() -> int:
    """Whoever read our lines has enough of them, as `head` may: nothing more is written there, not even at the end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return PIPE_CLOSED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("dshpm-jax", description="Labels optical motion capture.")
    parser.add_argument("--version", action="version", version=f"dshpm-jax {dshpm_jax.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        options = commands.add_parser(
            name,
            help=command.ABOUT,
            description=f"{command.ABOUT[0].upper()}{command.ABOUT[1:]}.",
            epilog=f"examples:\n{indent(EXAMPLES[name], '  ')}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        command.add_options(options)
        options.set_defaults(run=command.run)
    return parser


if __name__ == "__main__":
    sys.exit(main())
