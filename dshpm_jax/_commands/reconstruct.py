"""The command `reconstruct`: the motion of labelled recordings, and their gaps filled."""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dshpm_jax import io
from dshpm_jax._archive.jobs import C3D, TRC
from dshpm_jax._commands.forms import add_form, form_of
from dshpm_jax._commands.statuses import FAILURES, OK
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._console import add_reading, complain, say
from dshpm_jax._messages import UsageError, one_line
from dshpm_jax._model import SubjectModel
from dshpm_jax._reading import read_aloud, reading

if TYPE_CHECKING:
    from dshpm_jax._reconstruction import Motion


ABOUT = "the motion of the segments from labelled recordings"


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of `reconstruct`."""
    parser.add_argument("recordings", nargs="+", type=Path, metavar="LABELLED", help="labelled C3D or TRC file")
    parser.add_argument("--model", type=Path, required=True, metavar="MODEL", help="model of the subject")
    parser.add_argument(
        "-o", "--output", dest="out", type=Path, required=True, metavar="OUT", help="folder for the results"
    )
    parser.add_argument("--fill", action="store_true", help="fill the gaps of markers too, and write the points")
    parser.add_argument("--max-gap", type=float, metavar="SECONDS", help="leave longer gaps open (default: none)")
    parser.add_argument("--force", action="store_true", help="overwrite earlier results")
    add_form(parser.add_argument_group("how filled points are written"), (C3D, TRC))
    add_reading(parser)


def run(arguments: argparse.Namespace) -> int:
    """Reconstructs files one by one, and gives the exit status: 1 if some could not be."""
    if not arguments.model.is_file():
        raise UsageError(f"{arguments.model}: there is no such model; make one with 'dshpm-jax model'")
    if arguments.out.exists() and not arguments.out.is_dir():
        raise UsageError(f"{arguments.out}: is a file; give a folder for the results")
    form = form_of(arguments)
    if not arguments.fill and (form.changes_points or arguments.format != C3D):
        raise UsageError("--format, --up, --axes and --unit are of filled points; add --fill, or leave them out")
    if len({path.stem for path in arguments.recordings}) < len(arguments.recordings):
        raise UsageError("two recordings have the same name, and so would their results; give each its own OUT")
    cache_programs()
    try:
        model = io.read_model(arguments.model)
        arguments.out.mkdir(parents=True, exist_ok=True)
    except io.ReadError as error:
        complain(error)
        return FAILURES
    except OSError as error:
        complain(f"{arguments.out}: cannot be made ({error.strerror}); give another folder")
        return FAILURES
    troubles = [trouble for path in arguments.recordings for trouble in _reconstruct(path, model, arguments)]
    return FAILURES if troubles else OK


def _reconstruct(path: Path, model: SubjectModel, arguments: argparse.Namespace) -> Iterator[str]:
    """Writes the results of one file; says and yields a line if it could not."""
    from dshpm_jax._reconstruction import reconstruct, write_motion

    motion_file = arguments.out / f"{path.stem}.motion.npz"
    filled_file = arguments.out / f"{path.stem}.filled.{arguments.format}"
    try:
        for result in (motion_file, filled_file) if arguments.fill else (motion_file,):
            if result.exists() and not arguments.force:
                raise io.WriteError(result, "is there already, not overwritten", "give another folder or --force")
        motion = reconstruct(read_aloud(path, reading(arguments), model.markers), model)
        filled = motion.filled(arguments.max_gap) if arguments.fill else None
        write_motion(motion, motion_file, filled)
        if filled is not None:
            io.write_filled(*filled, filled_file, form_of(arguments))
    except (io.ReadError, io.WriteError) as error:
        trouble = str(error)
    except ValueError as error:
        trouble = f"{path}: {error}"
    except OSError as error:
        trouble = f"{arguments.out}: cannot be written ({error.strerror}); give another folder"
    except Exception as error:  # memory, say; the other files are none the worse
        trouble = f"{path}: {type(error).__name__}: {one_line(str(error))}"
    else:
        say(f"{path}: {_figures(motion, None if filled is None else filled.mask)}")
        return
    complain(trouble)
    yield trouble


def _figures(motion: "Motion", mask: np.ndarray | None) -> str:
    from dshpm_jax._reconstruction import Found

    shares = [f"{(motion.found == how).mean():.1%} {how.name.lower()}" for how in sorted(Found, reverse=True)]
    filled = "" if mask is None else f"; {int(mask.sum())} points filled"
    return f"{motion.recording.num_frames} frames, poses {', '.join(shares)}{filled}"
