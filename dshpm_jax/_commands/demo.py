"""The command `demo`: its options."""

import argparse
from pathlib import Path

from dshpm_jax._compile_cache import cache_programs

ABOUT = "a capture made on the spot, labelled, scored and drawn"


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of `demo`."""
    parser.add_argument("-o", "--output", dest="out", type=Path, metavar="OUT", help="folder for what it makes")
    parser.add_argument(
        "--archive", action="store_true", help="write a small archive to try every command on, and label nothing"
    )


def run(arguments: argparse.Namespace) -> int:
    """Makes one of the two and gives the exit status."""
    if arguments.archive:
        from dshpm_jax._demo.archive import run
    else:
        cache_programs()
        from dshpm_jax._demo.capture import run
    return run(arguments.out)
