"""Recordings and models as people give them: objects, or the files that hold them."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._marker_set import MarkerSet, Member
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Settings
from dshpm_jax._subjects import side_by_side

GivenRecording = Recording | str | Path
GivenModel = SubjectModel | str | Path
GivenModelOrSet = GivenModel | MarkerSet | Member
GivenModels = GivenModel | Sequence[GivenModel] | Mapping[str, GivenModel]


def recording_of(
    given: GivenRecording, model: SubjectModel | MarkerSet | Member | None = None, settings: Settings | None = None
) -> Recording:
    """A recording, read if it is given as a file (`ReadError` if it cannot be).

    Arguments:
        model: its markers are not left out of a file however much they seem to be computed.
        settings: say how files are read.
    """
    if isinstance(given, Recording):
        return given
    how = Settings() if settings is None else settings
    markers = () if model is None else model.markers
    return io.read(given, how.unlabelled, [*io.kept(markers), *how.drop], how.frozen_gaps)


def recordings_of(given: GivenRecording | Iterable[GivenRecording]) -> list[Recording]:
    """Recordings, each read if it is given as a file; one that stands alone makes a list of one."""
    return [recording_of(one) for one in one_or_more(given)]


def one_or_more(given: GivenRecording | Iterable[GivenRecording]) -> list[GivenRecording]:
    """A list of what is given; of one where it stands alone."""
    return [given] if isinstance(given, GivenRecording) else list(given)


def model_of(given: GivenModels) -> SubjectModel:
    """A model, read if it is given as a file; the models of several subjects make one (`combine_models`)."""
    if isinstance(given, SubjectModel):
        return given
    if isinstance(given, str | Path):
        return io.read_model(given)
    return combine_models(given)


def combine_models(models: Mapping[str, GivenModel] | Sequence[GivenModel]) -> SubjectModel:
    """One model of all subjects that a recording shows.

    Arguments:
        models: the subjects' names and models, or the files of these; subjects without names are called `subject1`,
            `subject2`, ...

    Markers and segments carry the subject's name before a colon, as capture systems write it: `anna:LKNE`. Every
    subject keeps a root of its own, and no distance between two subjects is known.

    Raises:
        ReadError: a file cannot be read.
        ValueError: there is no model, or a name holds a colon.
    """
    if isinstance(models, GivenModel):
        raise ValueError("one model was given alone; give a model for each subject")
    if not isinstance(models, Mapping):
        models = {f"subject{k + 1}": model for k, model in enumerate(models)}
    return side_by_side({name: model_of(model) for name, model in models.items()})


def model_or_set_of(given: GivenModels | MarkerSet | Member) -> SubjectModel | MarkerSet | Member:
    """What a recording is to be labelled with: the model of its subject or subjects, or a marker set."""
    if isinstance(given, MarkerSet | Member):
        return given
    return io.read_model_or_set(given) if isinstance(given, str | Path) else model_of(given)
