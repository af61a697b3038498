"""The command `model`: a marker model from labelled recordings or a subject file, or a marker set of many subjects."""

import argparse
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._commands.statuses import FAILURES, OK
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._console import add_reading, complain, say
from dshpm_jax._marker_set import MarkerSet
from dshpm_jax._marker_set.marker_set import names_of
from dshpm_jax._messages import UsageError
from dshpm_jax._model import SubjectModel
from dshpm_jax._reading import Reading, read_aloud, reading, say_joined
from dshpm_jax._recording import Recording, check_names_apart

ABOUT = "a marker model from labelled recordings of the subject"
TEMPLATES = ("body-parts", "helen-hayes", "plug-in-gait")
"""Those of `_model_building.templates`, whose import would make `--help` wait."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of `model`."""
    about = "labelled recordings, or a folder that directly holds some, or one subject file"
    parser.add_argument("recordings", nargs="*", type=Path, metavar="RECORDING", help=about)
    about = "make a marker set for subjects of whom nothing is labelled: a folder of labelled recordings of each other"
    parser.add_argument("--subjects", nargs="+", type=Path, metavar="FOLDER", help=about)
    about = "results of 'label' to learn from besides: those that a person confirmed, and of others what is sure"
    parser.add_argument("--from", dest="results", type=Path, metavar="FOLDER", help=about)
    about = "with --from: only what a person confirmed"
    parser.add_argument("--confirmed", action="store_true", help=about)
    about = "the model's file (JSON)"
    parser.add_argument("-o", "--output", dest="out", type=Path, required=True, metavar="MODEL", help=about)
    parser.add_argument("--markers", type=Path, metavar="XML", help="OpenSim's marker set beside an .osim file")
    add_how(parser)


def add_how(parser: argparse.ArgumentParser) -> None:
    """The options that say how a model is made, for `models` too."""
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--segments", type=Path, metavar="FILE", help="TOML file of segments and their markers")
    how.add_argument("--template", choices=TEMPLATES, help="take the segments from a known marker set")
    about = "do not compare the labels of a folder's recordings with the model of the others; that takes the longest"
    parser.add_argument("--no-check", dest="check", action="store_false", help=about)
    add_reading(parser)


def run(arguments: argparse.Namespace) -> int:
    """Makes the model and gives the exit status."""
    if arguments.out.exists() and not io.is_model(arguments.out):
        raise UsageError(f"{arguments.out}: is there and no marker model, not overwritten; give another file")
    if arguments.subjects:
        return _run_set(arguments)
    if not (arguments.recordings or arguments.results):
        raise UsageError("give labelled recordings, a folder of them or a subject file; or --subjects and folders")
    _check_sources(arguments)
    given, out = arguments.recordings, arguments.out
    if arguments.results:
        return _learnt(arguments)
    if not given[0].is_dir():
        return OK if written(lambda: _made_model(arguments), given, out) else FAILURES
    recordings = chosen_in(given[0], arguments)
    if not recordings:
        complain(f"{given[0]}: none of its own recordings can be used; 'dshpm-jax models' looks into its folders too")
        return FAILURES
    return OK if written(lambda: model_of(recordings, arguments), given, out) else FAILURES


def _learnt(arguments: argparse.Namespace) -> int:
    """A model of results, and of recordings that are given besides."""
    from dshpm_jax._archive.learning import lessons

    found = lessons(arguments.results, arguments.confirmed)
    for lesson in found:
        say(lesson)
    learnt = [lesson.recording for lesson in found if lesson.recording is not None]
    if not learnt:
        complain(f"{arguments.results}: none of its results can be used; confirm some in 'review', or label them again")
        return FAILURES

    def make() -> SubjectModel:
        return model_of(
            [*(_read_labelled(path, reading(arguments)) for path in arguments.recordings), *learnt], arguments
        )

    return OK if written(make, [*arguments.recordings, arguments.results], arguments.out) else FAILURES


def _run_set(arguments: argparse.Namespace) -> int:
    """Makes a marker set of the subjects' folders and gives the exit status."""
    folders, out = arguments.subjects, arguments.out
    if arguments.recordings or arguments.results or arguments.markers or arguments.segments or arguments.template:
        raise UsageError("--subjects: takes folders alone; leave recordings and the other options of a model out")
    for folder in folders:
        if not folder.is_dir():
            raise UsageError(
                f"{folder}: is no folder; --subjects takes a folder of labelled recordings for each subject"
            )
    names = [folder.resolve().name for folder in folders]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UsageError(f"two of the folders are called '{twice}', as subjects are after them; rename one")
    recordings = {name: chosen_in(folder, arguments) for name, folder in zip(names, folders, strict=True)}
    if without := [folder for name, folder in zip(names, folders, strict=True) if not recordings[name]]:
        complain(f"{without[0]}: none of its recordings can be used; leave it out or label one")
        return FAILURES
    try:
        markers = MarkerSet.from_subjects(recordings)
        out.parent.mkdir(parents=True, exist_ok=True)
        io.write_marker_set(markers, out)
    except io.WriteError as error:
        complain(error)
    except ValueError as error:
        complain(f"no marker set of {', '.join(map(str, folders))}: {error}")
    except OSError as error:
        complain(f"{out}: cannot be written ({error.strerror}); give another file")
    else:
        for line in _about_set(markers):
            say(line)
        say(f"{out}: a marker set of {markers.num_markers} markers from {len(names)} subjects")
        return OK
    return FAILURES


def _about_set(markers: MarkerSet) -> Iterator[str]:
    """What is to be said about the subjects of a set."""
    for one in markers.odd:
        yield (
            f"{one.subject}: {names_of(one.markers)} sit otherwise than in the others; if they were placed by another "
            "rule, or names were exchanged, leave this subject out"
        )
    some = [name for name, share in zip(markers.markers, markers.worn, strict=True) if share < 1]
    if some:
        yield f"not all subjects wear {names_of(some)}"
    if len(markers.subjects) < ENOUGH_SUBJECTS:
        yield f"{len(markers.subjects)} subjects tell little of how people differ; {ENOUGH_SUBJECTS} or more do"


ENOUGH_SUBJECTS = 4
"""count; used in `_about_set`: fewer subjects are few; evidence: a set of 41 markers labelled .54, .94, .96 and .99 of
new subjects from 1, 2, 4 and 8 others."""


def written(make: Callable[[], SubjectModel], sources: Sequence[Path], out: Path) -> bool:
    """Makes a model and writes it; whether that could be done, and a line about it."""
    try:
        model = make()
        out.parent.mkdir(parents=True, exist_ok=True)
        io.write_model(model, out)
    except (io.ReadError, io.WriteError) as error:
        complain(error)
    except ValueError as error:
        complain(f"no model of {', '.join(map(str, sources))}: {error}")
    except OSError as error:
        complain(f"{out}: cannot be written ({error.strerror}); give another file")
    else:
        say(f"{out}: {model.num_markers} markers in {len(model.segments)} segments")
        return True
    return False


def model_of(recordings: Sequence[Recording], arguments: argparse.Namespace) -> SubjectModel:
    """The model of recordings, with the options of `add_how`."""
    known = {name for r in recordings for name, named in zip(r.labels, r.labelled, strict=True) if named}
    segments = io.read_segments(arguments.segments, known) if arguments.segments else None
    return SubjectModel.from_recordings(recordings, segments=segments, template=arguments.template)


def chosen_in(folder: Path, arguments: argparse.Namespace) -> list[Recording]:
    """The recordings of a folder that a model is to be made of; says which, and why not the others."""
    from dshpm_jax._model_choice import choose, compare_labels  # imports scipy

    choice = choose(folder, reading(arguments))
    if arguments.check and len(choice.used) > 1:
        say(f"{folder}: comparing the labels of {len(choice.used)} recordings; --no-check leaves that out")
        cache_programs()
        compare_labels(choice)
    for line in choice.lines():
        say(line)
    return choice.used


def _check_sources(arguments: argparse.Namespace) -> None:
    given = arguments.recordings
    if not given and not arguments.results:
        raise UsageError("no recording is given; give labelled recordings, a folder of them, or --from results")
    if arguments.confirmed and not arguments.results:
        raise UsageError("--confirmed: says which results of --from count; give --from too")
    files = [path for path in given if path.suffix.lower() in io.SUBJECT_FILES]
    if files and (len(given) > 1 or arguments.results):
        raise UsageError(f"{files[0]}: a subject file makes a model alone; give it or recordings, not both")
    if arguments.markers and not files:
        raise UsageError(f"{arguments.markers}: a file of markers goes with an .osim file; leave out --markers")
    if files and (arguments.segments or arguments.template):
        raise UsageError(f"{files[0]}: a subject file says what its segments are; leave out --segments and --template")
    folders = [path for path in given if path.is_dir()]
    if folders and (len(given) > 1 or arguments.results):
        raise UsageError(f"{folders[0]}: a folder makes a model alone; give it or recordings, not both")


def _made_model(arguments: argparse.Namespace) -> SubjectModel:
    """The model of one subject file, or of recordings."""
    given = arguments.recordings
    if given[0].suffix.lower() in io.SUBJECT_FILES:
        return io.read_model(given[0], arguments.markers)
    return model_of([_read_labelled(path, reading(arguments)) for path in given], arguments)


def _read_labelled(path: Path, how: Reading) -> Recording:
    recording = read_aloud(path, how)
    check_names_apart(recording)
    say_joined(path, recording)
    if not recording.labelled.any():
        raise io.ReadError(path, "none of its points has a label", "a model needs a labelled recording")
    return recording
