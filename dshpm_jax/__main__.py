"""The command line: arguments in, one line for each file out."""

import argparse
import json
import os
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from dshpm_jax import _reconstructing, _viewing, io
from dshpm_jax._archive import UsageError, command
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._console import add_reading, complain, say
from dshpm_jax._experiments import command as experiments
from dshpm_jax._model import SubjectModel
from dshpm_jax._reading import Reading, read_aloud, reading, say_joined
from dshpm_jax._recording import Recording, check_names_apart
from dshpm_jax.io._atomic import write_whole

OK, FAILURES, WRONG_USAGE, INTERRUPTED, PIPE_CLOSED = 0, 1, 2, 130, 141


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command and gives its exit status."""
    arguments = _parser().parse_args(argv)
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
    parser.add_argument("--version", action="version", version=f"dshpm-jax {version('dshpm-jax')}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    demo = commands.add_parser("demo", help="a capture made on the spot, labelled, scored and drawn")
    demo.add_argument("-o", dest="out", type=Path, metavar="OUT", help="folder for what it makes")
    demo.set_defaults(run=_demo)

    model = commands.add_parser("model", help="a marker model from labelled recordings of the subject")
    model.add_argument(
        "recordings", nargs="+", type=Path, metavar="RECORDING", help="labelled recording, or one subject file"
    )
    model.add_argument("-o", dest="out", type=Path, required=True, metavar="MODEL", help="the model's file (JSON)")
    how = model.add_mutually_exclusive_group()
    how.add_argument("--segments", type=Path, metavar="FILE", help="TOML file of segments and their markers")
    how.add_argument("--template", metavar="NAME", help="a known marker set")
    model.add_argument("--markers", type=Path, metavar="XML", help="OpenSim's marker set beside an .osim file")
    add_reading(model)
    model.set_defaults(run=_model)

    label = commands.add_parser("label", help="labels recordings")
    command.add_options(label)
    label.set_defaults(run=command.run)

    check = commands.add_parser("check", help="audits the labels that recordings have")
    check.add_argument("recordings", nargs="+", type=Path, metavar="RECORDING", help="labelled recording")
    check.add_argument("--model", type=Path, required=True, metavar="MODEL", help="model of the subject")
    check.add_argument("--json", type=Path, metavar="FILE", help="write what was found there too")
    add_reading(check)
    check.set_defaults(run=_check)

    view = commands.add_parser("view", help="a page in which a labelled recording plays")
    _viewing.add_options(view)
    view.set_defaults(run=_viewing.run)

    experiment = commands.add_parser("experiment", help="the paper's experiments, with tables and figures")
    experiments.add_options(experiment)
    experiment.set_defaults(run=experiments.run)

    motion = commands.add_parser("reconstruct", help="the motion of the segments from labelled recordings")
    _reconstructing.add_options(motion)
    motion.set_defaults(run=_reconstructing.run)
    return parser


def _demo(arguments: argparse.Namespace) -> int:
    cache_programs()
    from dshpm_jax._demo import run

    return run(arguments.out)


def _model(arguments: argparse.Namespace) -> int:
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


def _check(arguments: argparse.Namespace) -> int:
    if not arguments.model.is_file():
        raise UsageError(f"{arguments.model}: there is no such model; make one with 'dshpm-jax model'")
    if arguments.json and (arguments.json.suffix != ".json" or not arguments.json.parent.is_dir()):
        raise UsageError(f"{arguments.json}: no place for the findings; give a .json file in a folder that is there")
    if arguments.json and not _may_be_findings(arguments.json):
        raise UsageError(f"{arguments.json}: is there and holds no findings, not overwritten; give another file")
    cache_programs()
    from dshpm_jax._checking import check_files

    rows, good = [], True
    for found in check_files(arguments.recordings, arguments.model, reading(arguments)):
        good &= found.sound
        rows += found.rows
        for line in found.troubles:
            complain(line)
        for line in found.lines:
            say(line)
    if arguments.json:
        good &= _written(rows, arguments.json)
    return OK if good else FAILURES


def _may_be_findings(path: Path) -> bool:
    """Whether the findings may be written to `path`: nothing is there, or findings of an earlier run."""
    if not path.exists():
        return True
    try:
        rows = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return False
    return isinstance(rows, list) and all(isinstance(row, dict) and "should_be" in row for row in rows)


def _written(rows: Sequence[object], path: Path) -> bool:
    try:
        write_whole(path, [(json.dumps(rows, indent=1) + "\n").encode()])
    except OSError as error:
        complain(f"{path}: cannot be written ({error.strerror}); give another file")
        return False
    return True


if __name__ == "__main__":
    sys.exit(main())
