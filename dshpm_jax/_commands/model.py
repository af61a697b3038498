"""The command `model`: a marker model from labelled recordings, or from the subject file of a capture system."""

import argparse
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._commands.statuses import FAILURES, OK
from dshpm_jax._console import add_reading, complain
from dshpm_jax._messages import UsageError
from dshpm_jax._model import SubjectModel
from dshpm_jax._reading import Reading, read_aloud, reading, say_joined
from dshpm_jax._recording import Recording, check_names_apart

ABOUT = "a marker model from labelled recordings of the subject"


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of `model`."""
    parser.add_argument(
        "recordings", nargs="+", type=Path, metavar="RECORDING", help="labelled recording, or one subject file"
    )
    parser.add_argument("-o", dest="out", type=Path, required=True, metavar="MODEL", help="the model's file (JSON)")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--segments", type=Path, metavar="FILE", help="TOML file of segments and their markers")
    how.add_argument("--template", metavar="NAME", help="a known marker set")
    parser.add_argument("--markers", type=Path, metavar="XML", help="OpenSim's marker set beside an .osim file")
    add_reading(parser)


def run(arguments: argparse.Namespace) -> int:
    """Makes the model and gives the exit status."""
    if arguments.out.exists() and not io.is_model(arguments.out):
        raise UsageError(f"{arguments.out}: is there and no marker model, not overwritten; give another file")
    _check_sources(arguments)
    try:
        model = _made_model(arguments)
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        io.write_model(model, arguments.out)
    except (io.ReadError, io.WriteError) as error:
        complain(error)
        return FAILURES
    except ValueError as error:
        complain(f"no model of {', '.join(map(str, arguments.recordings))}: {error}")
        return FAILURES
    except OSError as error:
        complain(f"{arguments.out}: cannot be written ({error.strerror}); give another file")
        return FAILURES
    print(f"{arguments.out}: {model.num_markers} markers in {len(model.segments)} segments")
    return OK


def _check_sources(arguments: argparse.Namespace) -> None:
    files = [path for path in arguments.recordings if path.suffix.lower() in io.SUBJECT_FILES]
    if files and len(arguments.recordings) > 1:
        raise UsageError(f"{files[0]}: a subject file makes a model alone; give it or recordings, not both")
    if arguments.markers and not files:
        raise UsageError(f"{arguments.markers}: a file of markers goes with an .osim file; leave out --markers")
    if files and (arguments.segments or arguments.template):
        raise UsageError(f"{files[0]}: a subject file says what its segments are; leave out --segments and --template")


def _made_model(arguments: argparse.Namespace) -> SubjectModel:
    """The model of one subject file, or of labelled recordings."""
    if arguments.recordings[0].suffix.lower() in io.SUBJECT_FILES:
        return io.read_model(arguments.recordings[0], arguments.markers)
    recordings = [_read_labelled(path, reading(arguments)) for path in arguments.recordings]
    known = {name for r in recordings for name, named in zip(r.labels, r.labelled, strict=True) if named}
    segments = io.read_segments(arguments.segments, known) if arguments.segments else None
    return SubjectModel.from_recordings(recordings, segments=segments, template=arguments.template)


def _read_labelled(path: Path, how: Reading) -> Recording:
    recording = read_aloud(path, how)
    check_names_apart(recording)
    say_joined(path, recording)
    if not recording.labelled.any():
        raise io.ReadError(path, "none of its points has a label", "a model needs a labelled recording")
    return recording
