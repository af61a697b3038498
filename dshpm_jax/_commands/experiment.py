"""The command `experiment`: its options."""

import argparse
from pathlib import Path

from dshpm_jax._compile_cache import cache_programs

ABOUT = "the paper's experiments, with tables and figures"
NAMES = ("table1", "distortion", "corruption", "complexity")


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of `experiment`."""
    add = parser.add_argument
    add("name", choices=NAMES)
    add("-o", "--output", dest="out", type=Path, metavar="OUT", help="folder; trials that it holds are gone on with")
    add("--trials", type=int, metavar="N", help="trials of each point (default: 500; of table1, 20 people)")
    add("--frames", type=int, default=600, metavar="N", help="of a trial, twice as many for freeform (default: 600)")
    add("--recording", type=Path, metavar="FILE", help="labelled C3D or TRC file to spoil, instead of made people")
    add("--model", type=Path, metavar="MODEL", help="model of the recording's subject")
    add("--workers", type=int, default=1, metavar="N", help="label in N processes (default: in this one)")
    add("--seed", type=int, default=2008, metavar="N", help="of all random numbers (default: 2008)")


def run(arguments: argparse.Namespace) -> int:
    """Runs the experiment and gives the exit status."""
    cache_programs()
    from dshpm_jax._experiments.running import ExperimentOrder, run  # imports jax

    return run(ExperimentOrder(**{name: getattr(arguments, name) for name in ExperimentOrder._fields}))
