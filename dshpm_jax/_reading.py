"""Recordings as commands read them: what is doubtful about a file is said, once."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TypedDict

from dshpm_jax import io
from dshpm_jax._console import complain
from dshpm_jax._recording import Recording, of_one_name


class Reading(TypedDict):
    """Arguments of `io.read` besides the file."""

    unlabelled: list[str]
    drop: list[str]
    frozen_gaps: bool


AS_USUAL: Reading = {"unlabelled": [], "drop": [], "frozen_gaps": True}
"""How files are read where nobody says otherwise."""


def reading(arguments: argparse.Namespace) -> Reading:
    """What the options of `add_reading` say."""
    return {
        "unlabelled": arguments.unlabelled,
        "drop": arguments.drop,
        "frozen_gaps": not arguments.keep_frozen,
    }


def say_joined(path: Path, recording: Recording) -> None:
    """Says which columns of one name a model joins."""
    for name, columns in of_one_name(recording).items():
        where = " and ".join(str(recording.columns[column] + 1) for column in columns)
        complain(f"{path}: columns {where} are both named '{name}' and take turns: joined")


def read_aloud(path: Path, how: Reading, markers: Sequence[str] = ()) -> Recording:
    """Reads a recording, and says on standard error what its reader noted.

    Arguments:
        markers: of the model, which are not left out however much they seem to be computed.
    """
    recording = io.read(path, how["unlabelled"], [*io.kept(markers), *how["drop"]], how["frozen_gaps"])
    for note in recording.notes:
        complain(f"{path}: {note}")
    return recording
