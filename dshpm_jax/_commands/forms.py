"""The options about how results are written, of all commands that write points."""

import argparse
from collections.abc import Sequence
from typing import Any

from dshpm_jax._messages import UsageError
from dshpm_jax._recording import MILLIMETRES
from dshpm_jax.io._form import AXES, Form

SAYS = {"c3d": "C3D", "trc": "TRC", "same": "that of each recording"}


def add_form(options: Any, formats: Sequence[str]) -> None:
    """The options themselves; the first of `formats` is the default."""
    about = f"of the results: {' or '.join(SAYS[name] for name in formats)} (default: {formats[0]})"
    options.add_argument("--format", choices=tuple(formats), default=formats[0], help=about)
    axes = options.add_mutually_exclusive_group()
    about = "turn the results so that this axis points up; OpenSim wants y"
    axes.add_argument("--up", choices=tuple(AXES), default="", help=about)
    about = "what x, y and z of the results are in the recording, such as x,z,-y (--axes=-y,x,z where a minus is first)"
    axes.add_argument("--axes", default="", metavar="X,Y,Z", help=about)
    options.add_argument("--unit", choices=tuple(MILLIMETRES), default="", help="of the results' lengths")
    if "same" in formats:
        about = "columns whose name the model does not know, and that get no label, keep this name"
        options.add_argument("--keep-unknown", action="store_true", help=about)


def form_of(arguments: argparse.Namespace) -> Form:
    """What the options say."""
    try:
        keep = getattr(arguments, "keep_unknown", False)
        return Form(arguments.axes, arguments.up, arguments.unit, keep)
    except ValueError as error:
        raise UsageError(f"--axes: {error}") from None
