"""The command `models`: a marker model in the folder of every subject."""

import argparse
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._commands.model import add_how, chosen_in, model_of, written
from dshpm_jax._commands.statuses import FAILURES, OK
from dshpm_jax._console import complain, say
from dshpm_jax._messages import UsageError

ABOUT = "a marker model for every subject's folder"
NAME = "model.json"


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of `models`."""
    about = f"folder of subjects' folders; each that directly holds labelled recordings gets a {NAME}"
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER", help=about)
    parser.add_argument("--dry-run", action="store_true", help="say which recordings would be used; write nothing")
    parser.add_argument("--force", action="store_true", help="replace models that are there")
    add_how(parser)


def run(arguments: argparse.Namespace) -> int:
    """Makes the models and gives the exit status: 1 if one could not be made, or if there was none to make."""
    for folder in arguments.folders:
        if not folder.is_dir():
            what = "is no folder" if folder.exists() else "there is no such folder"
            raise UsageError(f"{folder}: {what}; 'dshpm-jax model' makes a model of recordings")
    from dshpm_jax._model_choice import folders_of, recordings_in  # imports scipy

    closed: list[OSError] = []
    folders = dict.fromkeys(folder for top in arguments.folders for folder in folders_of(top, closed))
    outcomes = [_model_in(folder, arguments) for folder in folders if recordings_in(folder)]
    for error in closed:
        complain(f"{error.filename}: this folder cannot be searched ({error.strerror}); check its permissions")
    good, bad = outcomes.count(True), outcomes.count(False)
    what = "would be made or kept" if arguments.dry_run else "made or kept"
    say(f"{good} model{'s' if good != 1 else ''} {what}" + (f", {bad} could not be made" if bad else ""))
    return OK if good and not bad and not closed else FAILURES


def _model_in(folder: Path, arguments: argparse.Namespace) -> bool | None:
    """Makes the model of one folder; whether there is one now, None if nothing in the folder can be used."""
    out = folder / NAME
    if out.exists() and not io.is_model(out):
        complain(f"{out}: is there and no marker model, not overwritten; move it away")
        return False
    if out.exists() and not arguments.force:
        say(f"{out}: is there, kept; --force makes it again")
        return True
    recordings = chosen_in(folder, arguments)
    if not recordings:
        return None
    if arguments.dry_run:
        say(f"{out}: would be {'replaced' if out.exists() else 'made'}")
        return True
    return written(lambda: model_of(recordings, arguments), [folder], out)
