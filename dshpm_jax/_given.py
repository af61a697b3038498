"""Recordings and models as people give them: objects, or the files that hold them."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._subjects import combine_models
from dshpm_jax.io import read, read_model

GivenRecording = Recording | str | Path
GivenModel = SubjectModel | str | Path
GivenModels = GivenModel | Sequence[GivenModel] | Mapping[str, GivenModel]


def recording_of(given: GivenRecording) -> Recording:
    """A recording, read if it is given as a file (`ReadError` if it cannot be)."""
    return given if isinstance(given, Recording) else read(given)


def recordings_of(given: GivenRecording | Iterable[GivenRecording]) -> list[Recording]:
    """Recordings, each read if it is given as a file; one that stands alone makes a list of one."""
    if isinstance(given, GivenRecording):
        return [recording_of(given)]
    return [recording_of(one) for one in given]


def model_of(given: GivenModels) -> SubjectModel:
    """A model, read if it is given as a file; the models of several subjects make one (`combine_models`)."""
    if isinstance(given, SubjectModel):
        return given
    if isinstance(given, str | Path):
        return read_model(given)
    if isinstance(given, Mapping):
        return combine_models({name: model_of(one) for name, one in given.items()})
    return combine_models([model_of(one) for one in given])
